# Pure: knows no ROS.
"""The clocks that stamps follow: one offset for each, whatever the topics.

Stamps of one clock, such as that of a simulation, of a bag that is replayed or of another machine,
are moved together, so that the times between topics are exactly those between their stamps.
"""

from typing import List, Optional
from weakref import WeakSet

import numpy

from topic_scope.timing.lag import RECENT_NS, TOLERANCE_NS, Lag, median
from topic_scope.timing.nanoseconds import NS

#: Stamps within this at first are by the scope's clock, and are kept as they are [ns].
SAME_CLOCK_NS = NS // 2
#: Stamps further away than this are not late, but count from elsewhere [ns].
ELSEWHERE_NS = 3600 * NS
#: Two clocks that are far from the scope's are the same where they are this near one another: a
#: part of that distance, but no more than so much [ns].
_SAME_PART, _SAME_MOST_NS = 100, 60 * NS
#: Counts of seconds with a zero of their own are by one clock where they share values that were
#: received within this [ns].
_COPIED_NS = NS // 20


class Clock:
    """A clock that the stamps of some topics follow.

    :param is_scope: whether it is the scope's own clock, by which nothing is moved
    :param is_stamp: whether it counts stamps; else numbers with a zero of their own
    :param begin: the first reception [ns]

    :ivar offset: what is added to its times to get the scope's [ns]
    :ivar members: the lags of its topics
    """

    def __init__(self, is_scope: bool = False, is_stamp: bool = True, begin: int = 0) -> None:
        self.offset = 0
        self.is_scope, self.is_stamp = is_scope, is_stamp
        self.members: "WeakSet[Lag]" = WeakSet()
        self._begin = begin

    def follow(self, now: int, until: Optional[int] = None) -> bool:
        """Set the offset to the usual lag of the topics that have sent messages of late.

        The lower one of two middles counts: a topic that is delivered late says less of the clock.

        :param now: the latest reception [ns]
        :param until: how long after the first reception the offset may change [ns]; None for ever
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
        """Return the offset at a time of reception [ns], as its latest topic shows it."""
        latest = max(self.members, key=lambda one: one.received, default=None)
        if latest is None or not latest.drift:
            return self.offset
        return self.offset + latest.expected(now) - latest.expected(latest.received)

    def is_active(self, now: int) -> bool:
        """Return whether one of its topics has sent a message of late.

        :param now: the latest reception [ns]
        """
        return any(one.received >= now - RECENT_NS for one in self.members)

    def has_stamp_of(self, own: numpy.ndarray) -> bool:
        """Return whether one of its topics has shown one of these times [ns] of late."""
        return any(bool(numpy.isin(own, one.stamps()).any()) for one in self.members)


class Clocks:
    """The clocks of all topics of a recorder, or of a bag.

    :param until: how long after its first stamp the offset of a clock may change [ns]; None for
        ever, as where samples are drawn while they come

    :ivar scope: the scope's own clock
    :ivar changes: how often an offset, or the clock of a topic, has changed
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
        """Return the clock that some stamps of a topic follow, a new one where none fits.

        :param own: the stamps [ns]
        :param received: when their messages were received [ns]
        :param is_stamp: whether they are stamps; else numbers with a zero of their own
        :param is_exact: whether stamps keep their times if they count from the epoch at all
        :param left: a clock that they do not follow any more
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
        """Set the offset of a clock to what its topics show.

        :param now: the latest reception [ns]
        """
        self.changes += clock.follow(now, self._until)


def _same_within(apart: int, is_active: bool) -> int:
    """Return how near one another two topics of one clock are at least [ns]."""
    most = min(abs(apart) // _SAME_PART, _SAME_MOST_NS) if is_active else 0
    return max(SAME_CLOCK_NS, most)
