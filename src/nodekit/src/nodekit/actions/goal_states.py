"""States of a goal, and its transitions: those of actionlib_msgs/GoalStatus."""

import enum
from typing import Dict, Optional, Tuple


class GoalState(enum.IntEnum):
    """State of a goal, with its number in actionlib_msgs/GoalStatus."""

    PENDING = 0
    ACTIVE = 1
    PREEMPTED = 2
    SUCCEEDED = 3
    ABORTED = 4
    REJECTED = 5
    PREEMPTING = 6
    RECALLING = 7
    RECALLED = 8
    #: Only of a client: the server does not list the goal any longer.
    LOST = 9


class GoalEvent(enum.Enum):
    """Event at the server that changes a goal's state."""

    ACCEPT = "accept"
    REJECT = "reject"
    REQUEST_CANCEL = "request_cancel"
    CANCEL = "cancel"
    ABORT = "abort"
    SUCCEED = "succeed"


#: The state that follows an event; events that are missing are not allowed in that state.
TRANSITIONS: Dict[Tuple[GoalState, GoalEvent], GoalState] = {
    (GoalState.PENDING, GoalEvent.ACCEPT): GoalState.ACTIVE,
    (GoalState.PENDING, GoalEvent.REJECT): GoalState.REJECTED,
    (GoalState.PENDING, GoalEvent.REQUEST_CANCEL): GoalState.RECALLING,
    (GoalState.PENDING, GoalEvent.CANCEL): GoalState.RECALLED,
    (GoalState.RECALLING, GoalEvent.ACCEPT): GoalState.PREEMPTING,
    (GoalState.RECALLING, GoalEvent.REJECT): GoalState.REJECTED,
    (GoalState.RECALLING, GoalEvent.CANCEL): GoalState.RECALLED,
    (GoalState.ACTIVE, GoalEvent.REQUEST_CANCEL): GoalState.PREEMPTING,
    (GoalState.ACTIVE, GoalEvent.CANCEL): GoalState.PREEMPTED,
    (GoalState.ACTIVE, GoalEvent.ABORT): GoalState.ABORTED,
    (GoalState.ACTIVE, GoalEvent.SUCCEED): GoalState.SUCCEEDED,
    (GoalState.PREEMPTING, GoalEvent.CANCEL): GoalState.PREEMPTED,
    (GoalState.PREEMPTING, GoalEvent.ABORT): GoalState.ABORTED,
    (GoalState.PREEMPTING, GoalEvent.SUCCEED): GoalState.SUCCEEDED,
}
#: States of a goal that has ended.
ENDED = frozenset(
    {
        GoalState.PREEMPTED,
        GoalState.SUCCEEDED,
        GoalState.ABORTED,
        GoalState.REJECTED,
        GoalState.RECALLED,
        GoalState.LOST,
    }
)
#: States of a goal that the server has accepted and not ended.
RUNNING = frozenset({GoalState.ACTIVE, GoalState.PREEMPTING})
#: States of a goal whose cancellation was requested.
CANCELING = frozenset({GoalState.RECALLING, GoalState.PREEMPTING})


def state_after(state: GoalState, event: GoalEvent) -> Optional[GoalState]:
    """Return the state after an event; None if it is not allowed.

    :param state: the state before it
    :param event: the event
    """
    return TRANSITIONS.get((state, event))
