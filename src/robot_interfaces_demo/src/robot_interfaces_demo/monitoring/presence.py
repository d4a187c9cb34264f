"""Whether a robot is there: a table of states, and the time that leads through it."""

import enum
from typing import Dict, Tuple


class Presence(enum.Enum):
    """Whether a robot is there."""

    AWAITED = "awaited"
    NEVER_SEEN = "never seen"
    PRESENT = "present"
    STALE = "stale"
    LOST = "lost"
    RETURNING = "returning"


class Event(enum.Enum):
    """Events that may change it."""

    #: a message has arrived
    HEARD = "heard"
    #: none has for as long as is stale
    OVERDUE = "overdue"
    #: none has for as long as is lost
    GONE = "gone"
    #: they have arrived again, without being overdue, for as long as is stale
    SETTLED = "settled"


#: What does not stand here changes nothing.
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
    """Follows one robot through the table.

    How often :meth:`check_age` is called makes no difference to where it leads.

    :param state: the first state
    :param now: time, s

    :ivar state: the present state
    """

    def __init__(self, state: Presence, now: float) -> None:
        self.state = state
        self._heard_at = self._returned_at = now

    def age(self, now: float) -> float:
        """Return the time since the last message, or since it is awaited, s.

        :param now: time, s
        """
        return now - self._heard_at

    def check_age(self, now: float, stale_s: float, lost_s: float) -> None:
        """Record what time alone has changed.

        :param now: time, s
        :param stale_s: age of what is stale, s
        :param lost_s: age of what is lost, s; not below the other
        """
        age = now - self._heard_at
        if age > stale_s:
            self._apply(Event.OVERDUE)
            if age > lost_s:
                self._apply(Event.GONE)

    def add_message(self, now: float, stale_s: float, lost_s: float) -> None:
        """Record a message; parameters as those of :meth:`check_age`."""
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
