"""Requests to managed nodes, the same for nodekit's and rclpy's, and the record of their effects.

From each state each request is made by its number, by its label, and by both; each callback
succeeds, fails, is an error or raises an exception, and so does the callback after an error.
"""

import itertools
import json
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

#: Number and label of a transition; the label takes precedence.
Request = Tuple[int, str]

WAYS: Dict[str, List[str]] = {
    "unconfigured": [],
    "inactive": ["configure"],
    "active": ["configure", "activate"],
    "finalized": ["shutdown"],
}
#: Number and label of each allowed transition, and its state.
ALLOWED = [
    (1, "configure", "unconfigured"),
    (2, "cleanup", "inactive"),
    (3, "activate", "inactive"),
    (4, "deactivate", "active"),
    (5, "shutdown", "unconfigured"),
    (6, "shutdown", "inactive"),
    (7, "shutdown", "active"),
]
#: The services of a managed node, and their types.
SERVICES = {
    "change_state": "ChangeState",
    "get_state": "GetState",
    "get_available_states": "GetAvailableStates",
    "get_available_transitions": "GetAvailableTransitions",
    "get_transition_graph": "GetAvailableTransitions",
}
CALLBACKS = [
    "on_configure",
    "on_cleanup",
    "on_activate",
    "on_deactivate",
    "on_shutdown",
    "on_error",
]
LABELS = ["configure", "cleanup", "activate", "deactivate", "shutdown", "create", "destroy", "no"]
NUMBERS = [*range(13), 20, 30, 40, 50, 60, 97, 255]


class Case(NamedTuple):
    """Requests to a new node.

    :param way: labels of the transitions to the state in which the requests are made
    :param plan: outcome of each callback by its name; success unless given
    :param requests: the requests
    """

    way: List[str]
    plan: Dict[str, str]
    requests: List[Request]


def make_callbacks(outcomes: Any) -> Dict[str, Callable[..., Any]]:
    """Return the callbacks of a node with the attributes ``calls`` and ``plan``.

    :param outcomes: enumeration of the callbacks' results
    """

    def make(name: str) -> Callable[..., Any]:
        def call(self: Any, made: Any = None) -> Any:
            self.calls.append(name)
            planned = self.plan.get(name, "success")
            if planned == "raise":
                raise RuntimeError("on purpose")
            return getattr(outcomes, planned.upper())

        call.__name__ = name
        return call

    return {name: make(name) for name in CALLBACKS}


class Subject:
    """A managed node as its clients see it.

    :ivar events: start and goal of all events so far
    :ivar calls: names of the callbacks so far
    """

    def __init__(self) -> None:
        self.events: List[Any] = []
        self.calls: List[str] = []

    def call(self, service: str, number: int = 0, label: str = "") -> Any:
        """Call one of the SERVICES; the response is None if there is no answer."""
        raise NotImplementedError

    def settle(self) -> None:
        """Wait until all events have arrived."""

    def close(self) -> None:
        """End the node."""

    def add_event(self, event: Any) -> None:
        """Keep an event."""
        self.events.append([_pair(event.start_state), _pair(event.goal_state)])

    def change(self, number: int, label: str) -> bool:
        """Request a transition, and return whether it has succeeded."""
        response = self.call("change_state", number, label)
        return response is not None and bool(response.success)

    def state(self) -> List[Any]:
        """Return number and label of the state."""
        return _pair(self.call("get_state").current_state)

    def transitions(self, service: str) -> List[Any]:
        """Return number and label of transitions, and of their starts and goals."""
        return [
            [_pair(each.transition), _pair(each.start_state), _pair(each.goal_state)]
            for each in self.call(service).available_transitions
        ]

    def lists(self) -> List[Any]:
        """Return all states and all transitions, sorted because their order is undefined."""
        states = [_pair(state) for state in self.call("get_available_states").available_states]
        return [sorted(states), sorted(self.transitions("get_transition_graph"))]


def _pair(message: Any) -> List[Any]:
    return [message.id, message.label]


def cases() -> Dict[str, Case]:
    """Return all cases by their names."""
    found: Dict[str, Case] = {}
    for state, way in WAYS.items():
        allowed = [each for each in ALLOWED if each[2] == state]
        known = {number for number, _, _ in allowed}, {label for _, label, _ in allowed}
        refused: List[Request] = [(number, "") for number in NUMBERS if number not in known[0]]
        refused += [(0, label) for label in LABELS if label not in known[1]]
        refused += [(number, "no") for number in known[0]]
        found[f"{state}: refused requests"] = Case(way, {}, refused)
        for number, label, _ in allowed:
            others = [other for other, _, _ in ALLOWED if other != number]
            for request in ((number, ""), (0, label), (others[0], label)):
                found[f"{state}: {request}"] = Case(way, {}, [request])
            callback = f"on_{label}"
            plans = [{callback: "failure"}]
            for error, then in itertools.product(
                ("error", "raise"), ("success", "failure", "error", "raise")
            ):
                plans.append({callback: error, "on_error": then})
            for plan in plans:
                found[f"{state}: {label}, {plan}"] = Case(way, plan, [(number, "")])
    found["three rounds"] = Case(
        [], {}, [(0, label) for label in ("configure", "activate", "deactivate", "cleanup") * 3]
    )
    return found


def observe(case: Case, subject: Subject) -> List[Any]:
    """Make the requests of a case to a new node, and return the observations after each."""
    for label in case.way:
        subject.change(0, label)
    seen: List[Any] = subject.lists()
    for number, label in case.requests:
        subject.settle()
        subject.events.clear()
        subject.calls.clear()
        reply = subject.change(number, label)
        subject.settle()
        state, available = subject.state(), subject.transitions("get_available_transitions")
        seen.append([reply, state, available, list(subject.events), list(subject.calls)])
    subject.close()
    return seen


def print_all(make_subject: Callable[[Dict[str, str]], Subject]) -> None:
    """Print the observations of all cases, as JSON.

    :param make_subject: makes a node with a plan
    """
    seen = {name: observe(case, make_subject(case.plan)) for name, case in cases().items()}
    print(json.dumps(seen), flush=True)
