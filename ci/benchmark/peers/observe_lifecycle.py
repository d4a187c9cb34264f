"""Print the behaviour of nodekit's managed nodes in the cases of ``lifecycle_cases``, as JSON."""

import itertools
from typing import Any, Dict, List

from ci.benchmark import lifecycle_cases
from lifecycle_msgs import msg, srv
from nodekit import ManagedNode, Node, Outcome, init_node

#: Longest wait for an answer [s].
LIMIT = 10.0

_numbers = itertools.count()


class PlannedNode(type("Callbacks", (ManagedNode,), lifecycle_cases.make_callbacks(Outcome))):
    """Node with callbacks that have the outcomes of a case."""

    plan: Dict[str, str]

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.calls: List[str] = []


class Subject(lifecycle_cases.Subject):
    """A managed node in this process, and clients of its services."""

    def __init__(self, root: Node, plan: Dict[str, str]) -> None:
        super().__init__()
        made: List[PlannedNode] = []

        def make(node: Node) -> object:
            made.append(PlannedNode(node))
            return made[0]

        self._node = root.host("subject", f"/case{next(_numbers)}", make)
        made[0].plan, self.calls = plan, made[0].calls
        self._scope = root.create_scope()
        topic = self._node.resolve("~transition_event")
        self._scope.create_subscription(topic, msg.TransitionEvent, self.add_event)
        self._clients = {
            name: self._scope.create_client(self._node.resolve("~" + name), getattr(srv, kind))
            for name, kind in lifecycle_cases.SERVICES.items()
        }

    def call(self, service: str, number: int = 0, label: str = "") -> Any:
        request = getattr(srv, lifecycle_cases.SERVICES[service] + "Request")()
        if service == "change_state":
            request.transition = msg.Transition(number, label)
        return self._clients[service].call(request, LIMIT)

    def close(self) -> None:
        self._scope.close()
        self._node.close()


if __name__ == "__main__":
    node = init_node("transitions")
    node.start()
    lifecycle_cases.print_all(lambda plan: Subject(node, plan))
