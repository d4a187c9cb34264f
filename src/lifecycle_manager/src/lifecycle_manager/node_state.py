# Pure: knows no ROS.
"""States of managed nodes as the manager knows them; times by a monotonic clock [s]."""

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

#: The request to a node whose state is in doubt.
GET_STATE = "get_state"

#: Level of each state. A node in a transition counts as the level that is the safer one for the
#: others: unconfigured until it is configured, active until it is deactivated.
LEVELS = {
    **dict(enumerate(Level)),
    CONFIGURING.id: Level.UNCONFIGURED,
    CLEANINGUP.id: Level.UNCONFIGURED,
    ACTIVATING.id: Level.ACTIVE,
    DEACTIVATING.id: Level.ACTIVE,
}
#: Labels of the primary states; 0 is that of a node that does not answer.
STATES = ("absent", *(state.label for state in (UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED)))
#: States from which a transition is possible.
_ON = (UNCONFIGURED.id, INACTIVE.id, ACTIVE.id)
#: The state to which each transition leads.
RESULTS = {request.label: OUTCOMES[request.goal, Outcome.SUCCESS].goal.id for request in REQUESTS}


def state_text(state: int) -> str:
    """Return the name of a state for a sentence.

    :param state: its number
    """
    return STATES[state] if state < len(STATES) else "in the middle of a transition"


class NodeState:
    """State of one managed node as the manager knows it.

    :param name: its global name
    :param now: the time

    :ivar state: number of its state; 0 while it does not answer
    :ivar is_heard: whether its heartbeat is received
    :ivar heard_at: time of the last heartbeat
    :ivar query_at: when to ask for its state; infinite where that is not in doubt
    :ivar under_way: the request without a reply so far; empty without one
    :ivar told: number of the state that it has published last meanwhile, 0 for none
    :ivar is_stuck: whether a transition down has failed
    """

    def __init__(self, name: str, now: float) -> None:
        self.name = name
        self.state = 0
        self.is_heard = False
        self.heard_at = -math.inf
        self.query_at = math.inf
        self.under_way = ""
        self.told = 0
        self.is_stuck = False
        self._restless_since = now

    @property
    def level(self) -> Level:
        """Level of its state."""
        return LEVELS.get(self.state, Level.GONE)

    @property
    def is_busy(self) -> bool:
        """Whether its state is yet to be learnt."""
        return bool(self.under_way) or self.query_at < math.inf

    @property
    def is_moving(self) -> bool:
        """Whether it is in the middle of a transition."""
        return self.state >= len(STATES)

    @property
    def rests(self) -> bool:
        """Whether it is in a state from which a transition is possible."""
        return self.state in _ON

    def enter(self, state: int, now: float) -> None:
        """Record its state."""
        if state != self.state:
            self.is_stuck = False
        if self.rests and state not in _ON:
            self._restless_since = now
        self.state = state

    def is_overdue(self, since: float, window: float, now: float) -> bool:
        """Tell whether it should have come to rest by now.

        :param since: when the time began, at the earliest
        :param window: how long it may take, s
        """
        return not self.rests and now - max(since, self._restless_since) > window
