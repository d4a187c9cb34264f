"""Lifecycle (managed) nodes on the graph: their states, and transitions requested by pages."""

import time
from functools import partial
from typing import Any, Callable, Collection, Dict, List

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from nodekit import call_service
from topic_scope.graph.worker import Worker

#: Polling period of a node [s]; timeout of a transition [s].
AGAIN_S, _CHANGE_S = 2.0, 60.0
#: Most nodes to poll: the first by name.
NODES = 32
#: State of a node that no longer answers.
_SILENT = "does not answer"
_SERVICES = ("get_state", "get_available_transitions", "change_state")


class ManagedNodes:
    """Managed nodes, found by their services; all methods are for the web thread.

    They are polled, because a transition that crashes sends no event.

    :param worker: worker that waits for nodes
    :param send: sends a message to all pages
    """

    def __init__(self, worker: Worker, send: Callable[..., None]) -> None:
        self._worker, self._send = worker, send
        self._nodes: Dict[str, Dict[str, Any]] = {}
        self._present: Collection[str] = ()
        self._due: Dict[str, float] = {}

    def message(self) -> Dict[str, Any]:
        """Return the nodes that have answered."""
        return {"type": "managed", "nodes": [self._nodes[node] for node in sorted(self._nodes)]}

    def on_services(self, names: Collection[str]) -> None:
        """Update the services on the graph."""
        offered, end = set(names), "/" + _SERVICES[0]
        nodes = sorted(name[: -len(end)] for name in offered if name.endswith(end))
        nodes = [one for one in nodes if offered.issuperset(f"{one}/{name}" for name in _SERVICES)]
        self._present = nodes[:NODES]
        for node in set(self._nodes) - set(self._present):
            del self._nodes[node]
            self._send(self.message())
        for node in self._present:
            if time.monotonic() >= self._due.get(node, 0.0):
                self._ask_state(node)
        self._due = {node: due for node, due in self._due.items() if node in self._present}

    def change(self, node: str, label: str, answer: Callable[[Dict[str, Any]], None]) -> None:
        """Request a transition of a node.

        :param node: its name
        :param label: label of the transition
        :param answer: reports the result to the page
        :raises ValueError: if the transition is unavailable, or the node is busy with another one
        """
        if label not in self._nodes.get(node, {}).get("transitions", ()):
            raise ValueError(f"{node} cannot {label} now")
        service = f"{node}/change_state"
        work = partial(_change, service, label)
        then = partial(self._on_changed, node, label, answer)
        if not self._worker.run(("call", service), work, then):
            raise ValueError(f"{node} has not finished an earlier request yet")

    def _on_changed(
        self, node: str, label: str, answer: Callable[[Dict[str, Any]], None], result: Any
    ) -> None:
        if result is not True:
            why = f": {result}" if isinstance(result, Exception) else "; see its log"
            answer({"type": "error", "text": f"{node} did not {label}{why}"})
        self._ask_state(node)

    def _ask_state(self, node: str) -> None:
        self._due[node] = time.monotonic() + AGAIN_S
        self._worker.run(("managed", node), partial(_state_of, node), partial(self._on_state, node))

    def _on_state(self, node: str, reply: Any) -> None:
        if isinstance(reply, Exception):  # keep polling; the master still lists killed nodes
            if node not in self._nodes:
                return
            reply = {"node": node, "state": _SILENT, "transitions": []}
        if node in self._present and self._nodes.get(node) != reply:
            self._nodes[node] = reply
            self._send(self.message())


def _state_of(node: str) -> Dict[str, Any]:
    state = call_service(f"{node}/get_state", GetState).result().current_state.label
    offered = call_service(f"{node}/get_available_transitions", GetAvailableTransitions).result()
    labels: List[str] = [one.transition.label for one in offered.available_transitions]
    return {"node": node, "state": state, "transitions": labels}


def _change(service: str, label: str) -> bool:
    answer = call_service(service, ChangeState, Transition(label=label), timeout=_CHANGE_S)
    return bool(answer.result().success)
