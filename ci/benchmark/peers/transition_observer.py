"""Print what is observed of nodekit's managed nodes, in the cases of ``transitions``, as JSON."""

import itertools
import json
from typing import Any, Callable, Dict, List

from ci.benchmark import transitions
from lifecycle_msgs import msg, srv
from nodekit import Client, ManagedNode, Node, Outcome, init_node

#: Longest wait for an answer, s.
LIMIT = 10.0

_numbers = itertools.count()


def callback(name: str) -> Callable[..., Outcome]:
    """Return a callback that does what is planned for it."""

    def call(self: Any, made: Any = None) -> Outcome:
        self.calls.append(name)
        planned = self.plan.get(name, "success")
        if planned == "raise":
            raise RuntimeError("on purpose")
        return Outcome[planned.upper()]

    call.__name__ = name
    return call


class Planned(ManagedNode):
    """Does what a case plans."""

    plan: Dict[str, str]

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.calls: List[str] = []
        self.plan = {}

    on_configure = callback("on_configure")
    on_activate = callback("on_activate")
    on_deactivate = callback("on_deactivate")
    on_cleanup = callback("on_cleanup")
    on_shutdown = callback("on_shutdown")
    on_error = callback("on_error")


def subject(root: Node, plan: Dict[str, str]) -> transitions.Subject:
    """Make a managed node, and clients that ask it."""
    made: List[Planned] = []

    def make(node: Node) -> object:
        made.append(Planned(node))
        return made[0]

    node = root.host("subject", f"/case{next(_numbers)}", make)
    made[0].plan = plan
    asking = root.lifetime()
    events: List[Any] = []
    asking.subscribe(
        node.resolve("~transition_event"),
        msg.TransitionEvent,
        lambda event: events.append([_pair(event.start_state), _pair(event.goal_state)]),
    )
    change = asking.client(node.resolve("~change_state"), srv.ChangeState)
    state = asking.client(node.resolve("~get_state"), srv.GetState)
    states = asking.client(node.resolve("~get_available_states"), srv.GetAvailableStates)
    available, graph = (
        asking.client(node.resolve(f"~get_{name}"), srv.GetAvailableTransitions)
        for name in ("available_transitions", "transition_graph")
    )

    def listed(client: Client) -> List[Any]:
        answer = client.call(srv.GetAvailableTransitionsRequest(), LIMIT)
        return [
            [_pair(each.transition), _pair(each.start_state), _pair(each.goal_state)]
            for each in answer.available_transitions
        ]

    def lists() -> List[Any]:
        answer = states.call(srv.GetAvailableStatesRequest(), LIMIT)
        return [[_pair(state) for state in answer.available_states], listed(graph)]

    def close() -> None:
        asking.close()
        node.close()

    return transitions.Subject(
        lambda number, label: bool(
            change.call(srv.ChangeStateRequest(msg.Transition(number, label)), LIMIT).success
        ),
        lambda: _pair(state.call(srv.GetStateRequest(), LIMIT).current_state),
        lambda: listed(available),
        lists,
        events,
        made[0].calls,
        close,
    )


def _pair(message: Any) -> List[Any]:
    return [message.id, message.label]


def main() -> None:
    """Observe and print."""
    root = init_node("transitions")
    root.start()
    results = {}
    for name, case in transitions.cases().items():
        results[name] = transitions.observe(case, subject(root, case.plan), lambda: None)
    print(json.dumps(results))


if __name__ == "__main__":
    main()
