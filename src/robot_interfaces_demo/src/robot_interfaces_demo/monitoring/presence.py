"""Presence of a robot: a state table, and the timeouts that drive it."""

import enum
from typing import Dict, Tuple


class Presence(enum.Enum):
    """Presence of a robot."""

    AWAITED = "awaited"
    NEVER_SEEN = "never seen"
    PRESENT = "present"
    STALE = "stale"
    LOST = "lost"
    RETURNING = "returning"


class Event(enum.Enum):
    """Events of the table."""

    #: a message has arrived
    HEARD = "heard"
    #: no message for the time after which a robot is stale
    OVERDUE = "overdue"
    #: no message for the time after which a robot is lost
    GONE = "gone"
    #: messages have arrived on time again for the time after which a robot is stale
    SETTLED = "settled"


#: Other events do not change the state.
TRANSITIONS: Dict[Tuple[Presence, Event], Presence] = {
    (Presence.AWAITED, Event.HEARD): Presence.PRESENT,
    (Presence.AWAITED, Event.OVERDUE): Presence.NEVER_SEEN,
    (Presence.NEVER_SEEN, Event.HEARD): Presence.PRESENT,
    (Presence.PRESENT, Event.OVERDUE): Presence.STALE,
    (Presence.STALE, Event.HEARD): Presence.RETURNING,
    (Presence.STALE, Event.GONE): Presence.LOST,
    (Presence.LOST, Event.HEARD): Presence.RETURNING,
    (Presence.RETURNING, Event.OVERDUE): Presence.STALE,
    (Presence.RETURNING, Event.SETTLED): Presence.PRESENT,
}


class Attendance:
    """Presence of one robot, by the table.

    The result does not depend on how often :meth:`check_age` is called.

    :param state: the first state
    :param now: time [s]

    :ivar state: the current state
    """

    def __init__(self, state: Presence, now: float) -> None:
        self.state = state
        self._heard_at = self._returned_at = now

    def age(self, now: float) -> float:
        """Return the time since the last message, or since the robot is expected [s].

        :param now: time [s]
        """
        return now - self._heard_at

    def check_age(self, now: float, stale_s: float, lost_s: float) -> None:
        """Record changes that follow from time alone.

        :param now: time [s]
        :param stale_s: age at which a robot is stale [s]
        :param lost_s: age at which a robot is lost [s], not below ``stale_s``
        """
        age = now - self._heard_at
        if age > stale_s:
            self._apply(Event.OVERDUE)
            if age > lost_s:
                self._apply(Event.GONE)

    def add_message(self, now: float, stale_s: float, lost_s: float) -> None:
        """Record a message; parameters as for :meth:`check_age`."""
        self.check_age(now, stale_s, lost_s)
        self._heard_at = now
        if self.state is Presence.PRESENT:
            return
        was_returning = self.state is Presence.RETURNING
        self._apply(Event.HEARD)
        if not was_returning:
            self._returned_at = now
        elif now - self._returned_at >= stale_s:
            self._apply(Event.SETTLED)

    def _apply(self, event: Event) -> None:
        self.state = TRANSITIONS.get((self.state, event), self.state)
