# Pure: knows no ROS.
"""What a manager knows of one node; time is that of any clock that never goes back, s."""

import math

from lifecycle_manager.plan import Level

#: The request to a node whose state is in doubt.
GET_STATE = "get_state"

#: How far up a node is in each of ROS 2's states. One in a transition counts as what is the safer
#: for the others: not configured until it is, active until it is not.
LEVELS = {
    **dict(enumerate(Level)),
    10: Level.UNCONFIGURED,
    11: Level.UNCONFIGURED,
    13: Level.ACTIVE,
    14: Level.ACTIVE,
}
#: The primary states; 0 is that of a node that does not answer.
STATES = ("absent", "unconfigured", "inactive", "active", "finalized")
#: Those from which a transition is possible.
_ON = (1, 2, 3)
#: The state that each transition leads to.
RESULTS = {"configure": 2, "activate": 3, "deactivate": 2, "cleanup": 1, "shutdown": 4}


def state_text(state: int) -> str:
    """Return the name of a state for a sentence.

    :param state: its number
    """
    return STATES[state] if state < len(STATES) else "in the middle of a transition"


class Member:
    """What is known of one node.

    :param name: its global name
    :param now: the time

    :ivar state: number of its state; 0 while it does not answer
    :ivar is_heard: whether its heartbeat is received
    :ivar heard_at: time of the last heartbeat
    :ivar query_at: when to ask for its state; infinite where that is not in doubt
    :ivar under_way: the request that it has not answered yet; empty where there is none
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
        """How far up it is."""
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
