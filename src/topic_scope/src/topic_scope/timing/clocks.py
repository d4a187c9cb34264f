# Pure: knows no ROS.
"""Clocks behind message stamps (simulation, other machine), and their offsets to the scope's.

Stamps of one clock, such as the clock of a simulation, of a replayed bag or of another machine, are
shifted together, so that the times between topics are exactly the times between their stamps.
"""

from typing import List, Optional
from weakref import WeakSet

import numpy

from topic_scope.timing.lag import RECENT_NS, TOLERANCE_NS, Lag, median
from topic_scope.timing.nanoseconds import NS

#: Stamps that initially differ by less are by the scope's clock, and are not shifted [ns].
SAME_CLOCK_NS = NS // 2
#: Stamps that differ by more are not late, but have another zero [ns].
ELSEWHERE_NS = 3600 * NS
#: Two clocks far from the scope's clock are the same if they differ by less than this: a part of
#: their distance from the scope's clock, up to a limit [ns].
_SAME_PART, _SAME_MOST_NS = 100, 60 * NS
#: Counts of seconds with an unknown zero are by one clock if they share values that were
#: received within this [ns].
_COPIED_NS = NS // 20


class Clock:
    """Clock of the stamps of some topics.

    :param is_scope: whether it is the scope's own clock, which has no offset
    :param is_stamp: whether its times are stamps; otherwise numbers with an unknown zero
    :param begin: first time of receipt [ns]

    :ivar offset: added to its times to get the scope's [ns]
    :ivar members: the lags of its topics
    """

    def __init__(self, is_scope: bool = False, is_stamp: bool = True, begin: int = 0) -> None:
        self.offset = 0
        self.is_scope, self.is_stamp = is_scope, is_stamp
        self.members: "WeakSet[Lag]" = WeakSet()
        self._begin = begin

    def follow(self, now: int, until: Optional[int] = None) -> bool:
        """Set the offset to the usual lag of the recently active topics.

        Uses the lower median: a topic that is delivered late is less informative.

        :param now: latest time of receipt [ns]
        :param until: how long after the first receipt the offset may change [ns]; None forever
        :returns: whether the offset has changed
        """
        if self.is_scope or (until is not None and now > self._begin + until):
            return False
        lags = [one.expected(now) for one in self.members if one.received >= now - RECENT_NS]
        target = median(numpy.array(lags, numpy.int64))
        if abs(target - self.offset) <= TOLERANCE_NS:
            return False
        self.offset = target
        return True

    def expected(self, now: int) -> int:
        """Return the offset at a time of receipt [ns], from its most recent topic."""
        latest = max(self.members, key=lambda one: one.received, default=None)
        if latest is None or not latest.drift:
            return self.offset
        return self.offset + latest.expected(now) - latest.expected(latest.received)

    def is_active(self, now: int) -> bool:
        """Return whether one of its topics was active recently.

        :param now: latest time of receipt [ns]
        """
        return any(one.received >= now - RECENT_NS for one in self.members)

    def has_stamp_of(self, own: numpy.ndarray) -> bool:
        """Return whether one of its topics recently had one of these stamps [ns]."""
        return any(bool(numpy.isin(own, one.stamps()).any()) for one in self.members)


class Clocks:
    """Clocks of all topics of a recorder or a bag.

    :param until: how long after its first stamp the offset of a clock may change [ns]; None
        forever, for live traces

    :ivar scope: the scope's own clock
    :ivar changes: number of changes of an offset, or of a topic's clock
    """

    def __init__(self, until: Optional[int] = None) -> None:
        self.scope = Clock(is_scope=True)
        self.changes = 0
        self._until = until
        self._others: List[Clock] = []

    def find(
        self,
        own: numpy.ndarray,
        received: numpy.ndarray,
        is_stamp: bool,
        is_exact: bool,
        left: Optional[Clock] = None,
    ) -> Clock:
        """Return the clock of some stamps of a topic, a new clock if none fits.

        :param own: the stamps [ns]
        :param received: when their messages were received [ns]
        :param is_stamp: whether they are stamps; otherwise numbers with an unknown zero
        :param is_exact: whether stamps that count from the epoch are not shifted
        :param left: the previous clock, which they no longer follow
        """
        apart, now = median(received - own), int(received[-1])
        if is_stamp and abs(apart) < (ELSEWHERE_NS if is_exact else SAME_CLOCK_NS):
            return self.scope
        self._others = [one for one in self._others if one.members]
        known = sorted(self._others, key=lambda one: abs(one.expected(now) - apart))
        for clock in known:
            if clock.is_stamp != is_stamp or clock is left:
                continue
            distance = abs(clock.expected(now) - apart)
            if is_stamp:
                is_same = distance < _same_within(apart, clock.is_active(now))
            else:
                is_same = distance < _COPIED_NS and clock.has_stamp_of(own)
            if is_same:
                return clock
        made = Clock(is_stamp=is_stamp, begin=int(received[0]))
        made.offset = apart
        self._others.append(made)
        return made

    def follow(self, clock: Clock, now: int) -> None:
        """Update the offset of a clock from its topics.

        :param now: latest time of receipt [ns]
        """
        self.changes += clock.follow(now, self._until)


def _same_within(apart: int, is_active: bool) -> int:
    """Return the largest difference of two topics of one clock [ns]."""
    most = min(abs(apart) // _SAME_PART, _SAME_MOST_NS) if is_active else 0
    return max(SAME_CLOCK_NS, most)
