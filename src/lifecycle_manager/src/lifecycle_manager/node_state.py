# Pure: knows no ROS.
"""States of managed nodes, as known to the manager; times by a monotonic clock [s]."""

import math

from lifecycle_manager.plan import Level
from nodekit.lifecycle_states import (
    ACTIVATING,
    ACTIVE,
    CLEANINGUP,
    CONFIGURING,
    DEACTIVATING,
    FINALIZED,
    INACTIVE,
    OUTCOMES,
    REQUESTS,
    UNCONFIGURED,
    Outcome,
)

#: Request to a node with unknown state.
GET_STATE = "get_state"

#: Level of each state. During a transition, a node has the level that is safer for the others:
#: unconfigured until it is configured, active until it is deactivated.
LEVELS = {
    **dict(enumerate(Level)),
    CONFIGURING.id: Level.UNCONFIGURED,
    CLEANINGUP.id: Level.UNCONFIGURED,
    ACTIVATING.id: Level.ACTIVE,
    DEACTIVATING.id: Level.ACTIVE,
}
#: Labels of the primary states; 0 stands for a node that does not answer.
STATES = ("absent", *(state.label for state in (UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED)))
#: States that allow transitions.
_ON = (UNCONFIGURED.id, INACTIVE.id, ACTIVE.id)
#: Resulting state of each transition.
RESULTS = {request.label: OUTCOMES[request.goal, Outcome.SUCCESS].goal.id for request in REQUESTS}


def state_text(state: int) -> str:
    """Return the name of a state, for messages.

    :param state: its number
    """
    return STATES[state] if state < len(STATES) else "in transition"


class NodeState:
    """State of one managed node, as known to the manager.

    :param name: its global name
    :param now: current time

    :ivar state: number of its state; 0 while it does not answer
    :ivar is_heard: whether its heartbeat is received
    :ivar heard_at: time of the last heartbeat
    :ivar query_at: time of the next state query; infinite if the state is known
    :ivar under_way: the pending request; empty without one
    :ivar published: last state that it has published meanwhile, 0 for none
    :ivar is_stuck: whether a transition down has failed
    """

    def __init__(self, name: str, now: float) -> None:
        self.name = name
        self.state = 0
        self.is_heard = False
        self.heard_at = -math.inf
        self.query_at = math.inf
        self.under_way = ""
        self.published = 0
        self.is_stuck = False
        self._restless_since = now

    @property
    def level(self) -> Level:
        """Level of its state."""
        return LEVELS.get(self.state, Level.GONE)

    @property
    def is_busy(self) -> bool:
        """Whether its state is unknown until a reply."""
        return bool(self.under_way) or self.query_at < math.inf

    @property
    def is_moving(self) -> bool:
        """Whether it is in transition."""
        return self.state >= len(STATES)

    @property
    def rests(self) -> bool:
        """Whether it is in a state that allows transitions."""
        return self.state in _ON

    def enter(self, state: int, now: float) -> None:
        """Record its state."""
        if state != self.state:
            self.is_stuck = False
        if self.rests and state not in _ON:
            self._restless_since = now
        self.state = state

    def is_overdue(self, since: float, window: float, now: float) -> bool:
        """Return whether it should have reached a primary state by now.

        :param since: earliest start of the time window
        :param window: length of the window [s]
        """
        return not self.rests and now - max(since, self._restless_since) > window
