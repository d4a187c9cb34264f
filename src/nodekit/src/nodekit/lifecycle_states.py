# Pure: knows no ROS.
"""States and transitions of managed nodes, with ROS 2's ids and labels."""

import enum
from typing import Dict, List, NamedTuple, Tuple, Union


class State(NamedTuple):
    """State of a managed node.

    :param id: ROS 2's number
    :param label: its name
    """

    id: int
    label: str


class Transition(NamedTuple):
    """Transition from one state to another.

    :param id: ROS 2's number
    :param label: its name, which is not unique
    :param start: the state that it leaves
    :param goal: the state that it leads to
    """

    id: int
    label: str
    start: State
    goal: State


class Outcome(enum.IntEnum):
    """Outcome of a callback, with ROS 2's numbers."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99


class NotAllowed(ValueError):
    """Error of a transition that the present state does not allow; the text lists those it does."""


UNKNOWN = State(0, "unknown")
UNCONFIGURED = State(1, "unconfigured")
INACTIVE = State(2, "inactive")
ACTIVE = State(3, "active")
FINALIZED = State(4, "finalized")
CONFIGURING = State(10, "configuring")
CLEANINGUP = State(11, "cleaningup")
SHUTTINGDOWN = State(12, "shuttingdown")
ACTIVATING = State(13, "activating")
DEACTIVATING = State(14, "deactivating")
ERRORPROCESSING = State(15, "errorprocessing")

#: All states: the first five are primary, in the others a callback is running.
STATES = (
    *(UNKNOWN, UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED),
    *(CONFIGURING, CLEANINGUP, SHUTTINGDOWN, ACTIVATING, DEACTIVATING, ERRORPROCESSING),
)

#: Transitions that can be requested.
REQUESTS = (
    Transition(1, "configure", UNCONFIGURED, CONFIGURING),
    Transition(2, "cleanup", INACTIVE, CLEANINGUP),
    Transition(3, "activate", INACTIVE, ACTIVATING),
    Transition(4, "deactivate", ACTIVE, DEACTIVATING),
    Transition(5, "shutdown", UNCONFIGURED, SHUTTINGDOWN),
    Transition(6, "shutdown", INACTIVE, SHUTTINGDOWN),
    Transition(7, "shutdown", ACTIVE, SHUTTINGDOWN),
)

#: For each callback the number of the transition at success, and the goals at success, failure
#: and error. The transitions at failure and error have the next two numbers.
_GOALS: Dict[State, Tuple[int, State, State, State]] = {
    CONFIGURING: (10, INACTIVE, UNCONFIGURED, ERRORPROCESSING),
    CLEANINGUP: (20, UNCONFIGURED, INACTIVE, ERRORPROCESSING),
    ACTIVATING: (30, ACTIVE, INACTIVE, ERRORPROCESSING),
    DEACTIVATING: (40, INACTIVE, ACTIVE, ERRORPROCESSING),
    SHUTTINGDOWN: (50, FINALIZED, FINALIZED, ERRORPROCESSING),
    ERRORPROCESSING: (60, UNCONFIGURED, FINALIZED, FINALIZED),
}

#: Transitions that follow from the outcome of a callback.
OUTCOMES: Dict[Tuple[State, Outcome], Transition] = {
    (state, outcome): Transition(
        first + number, f"transition_{outcome.name.lower()}", state, goals[number]
    )
    for state, (first, *goals) in _GOALS.items()
    for number, outcome in enumerate(Outcome)
}

#: All transitions, in the order of their numbers.
TRANSITIONS = (*REQUESTS, *OUTCOMES.values())


def available(state: State) -> List[Transition]:
    """List the transitions that leave a state.

    :param state: the state
    """
    return [transition for transition in TRANSITIONS if transition.start == state]


def requested(state: State, wanted: Union[int, str]) -> Transition:
    """Return the requested transition.

    :param state: the present state
    :param wanted: label, or number
    :raises NotAllowed: if this state does not allow it
    """
    allowed = [transition for transition in REQUESTS if transition.start == state]
    for transition in allowed:
        if wanted in (transition.label, transition.id):
            return transition
    named = [each for each in REQUESTS if wanted in (each.label, each.id)]
    what = named[0].label if named else f"transition {wanted!r}"
    hint = ", ".join(f"{each.label} [{each.id}]" for each in allowed) or "none"
    raise NotAllowed(f"{what} is not allowed in the state {state.label}; allowed: {hint}")
