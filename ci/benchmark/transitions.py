"""What is asked of managed nodes, the same of nodekit's and of rclpy's, and what is seen of them.

From each state each request is made by its number, by its label, and by both; each callback
succeeds, fails, is an error or raises something, and so does what is called after an error. The
programs that observe it import this module, with nodekit or with rclpy.
"""

import itertools
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

#: Number and label of what is asked for; a label beats a number.
Request = Tuple[int, str]

WAYS: Dict[str, List[str]] = {
    "unconfigured": [],
    "inactive": ["configure"],
    "active": ["configure", "activate"],
    "finalized": ["shutdown"],
}
#: Number and label of what may be asked for, and in which state.
ALLOWED = [
    (1, "configure", "unconfigured"),
    (2, "cleanup", "inactive"),
    (3, "activate", "inactive"),
    (4, "deactivate", "active"),
    (5, "shutdown", "unconfigured"),
    (6, "shutdown", "inactive"),
    (7, "shutdown", "active"),
]
LABELS = ["configure", "cleanup", "activate", "deactivate", "shutdown", "create", "destroy", "no"]
NUMBERS = [*range(13), 20, 30, 40, 50, 60, 97, 255]


class Case(NamedTuple):
    """A new node, and what is asked of it.

    :param way: labels of what it is brought to a state by
    :param plan: what its callbacks do, by name; they succeed where nothing is said
    :param requests: what is asked then
    """

    way: List[str]
    plan: Dict[str, str]
    requests: List[Request]


class Subject(NamedTuple):
    """A managed node as its users see it.

    :param change: asks for a transition, and returns whether it has succeeded
    :param state: returns number and label
    :param available: returns number and label of each transition, and of its start and goal
    :param lists: returns all states and all transitions
    :param events: start and goal of all events so far
    :param calls: names of the callbacks so far
    :param close: ends it
    """

    change: Callable[[int, str], bool]
    state: Callable[[], List[Any]]
    available: Callable[[], List[Any]]
    lists: Callable[[], List[Any]]
    events: List[Any]
    calls: List[str]
    close: Callable[[], None]


def cases() -> Dict[str, Case]:
    """Return all cases by their names."""
    found: Dict[str, Case] = {}
    for state, way in WAYS.items():
        allowed = [each for each in ALLOWED if each[2] == state]
        known = {number for number, _, _ in allowed}, {label for _, label, _ in allowed}
        refused: List[Request] = [(number, "") for number in NUMBERS if number not in known[0]]
        refused += [(0, label) for label in LABELS if label not in known[1]]
        refused += [(number, "no") for number in known[0]]
        found[f"{state}: what is refused"] = Case(way, {}, refused)
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
    found["round and round"] = Case(
        [], {}, [(0, label) for label in ("configure", "activate", "deactivate", "cleanup") * 3]
    )
    return found


def observe(case: Case, subject: Subject, settle: Callable[[], None]) -> List[Any]:
    """Make the requests of a case, and note what is seen after each.

    :param subject: a new node
    :param settle: waits until all events have come
    """
    for label in case.way:
        subject.change(0, label)
    seen: List[Any] = [sorted(each) for each in subject.lists()]  # their order says nothing
    for number, label in case.requests:
        settle()
        subject.events.clear()
        subject.calls.clear()
        reply = subject.change(number, label)
        settle()
        state, available = subject.state(), subject.available()
        seen.append([reply, state, available, list(subject.events), list(subject.calls)])
    subject.close()
    return seen
