# Pure: knows no ROS.
"""The states of a managed node and the ways between them, with ROS 2's ids and labels."""

import enum
from typing import Dict, List, NamedTuple, Tuple, Union


class State(NamedTuple):
    """A state.

    :param id: ROS 2's number
    :param label: its name
    """

    id: int
    label: str


class Transition(NamedTuple):
    """A way from one state to another.

    :param id: ROS 2's number
    :param label: its name; several may have the same
    :param start: the state that it leaves
    :param goal: the state that it leads to
    """

    id: int
    label: str
    start: State
    goal: State


class Outcome(enum.IntEnum):
    """What became of a callback, with ROS 2's numbers."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99


class NotAllowed(ValueError):
    """A transition that does not exist, or not from here; the text lists those that do."""


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

#: All states. A node rests in the first five, and in the others one of its callbacks is under way.
STATES = (
    *(UNKNOWN, UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED),
    *(CONFIGURING, CLEANINGUP, SHUTTINGDOWN, ACTIVATING, DEACTIVATING, ERRORPROCESSING),
)

#: Those that may be asked for.
REQUESTS = (
    Transition(1, "configure", UNCONFIGURED, CONFIGURING),
    Transition(2, "cleanup", INACTIVE, CLEANINGUP),
    Transition(3, "activate", INACTIVE, ACTIVATING),
    Transition(4, "deactivate", ACTIVE, DEACTIVATING),
    Transition(5, "shutdown", UNCONFIGURED, SHUTTINGDOWN),
    Transition(6, "shutdown", INACTIVE, SHUTTINGDOWN),
    Transition(7, "shutdown", ACTIVE, SHUTTINGDOWN),
)

#: Where each callback leads to: number of the transition at success, goals at success, failure
#: and error. Failure and error have the next two numbers.
_GOALS: Dict[State, Tuple[int, State, State, State]] = {
    CONFIGURING: (10, INACTIVE, UNCONFIGURED, ERRORPROCESSING),
    CLEANINGUP: (20, UNCONFIGURED, INACTIVE, ERRORPROCESSING),
    ACTIVATING: (30, ACTIVE, INACTIVE, ERRORPROCESSING),
    DEACTIVATING: (40, INACTIVE, ACTIVE, ERRORPROCESSING),
    SHUTTINGDOWN: (50, FINALIZED, FINALIZED, ERRORPROCESSING),
    ERRORPROCESSING: (60, UNCONFIGURED, FINALIZED, FINALIZED),
}

#: Those that follow from what became of a callback.
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
    """Return the transition that is asked for.

    :param state: the present state
    :param wanted: label, or number
    :raises NotAllowed: if it may not be asked for in this state
    """
    allowed = [transition for transition in REQUESTS if transition.start == state]
    for transition in allowed:
        if wanted in (transition.label, transition.id):
            return transition
    named = [each for each in REQUESTS if wanted in (each.label, each.id)]
    what = named[0].label if named else f"transition {wanted!r}"
    hint = ", ".join(f"{each.label} [{each.id}]" for each in allowed) or "none"
    raise NotAllowed(f"{what} is not allowed in the state {state.label}; allowed: {hint}")
