"""The period of what arrives again and again, learnt from when it arrives."""

import collections
from typing import Deque, Optional

#: Shortest period, s: a busy machine delays messages by as much.
LEAST_PERIOD_S = 0.1
#: Arrivals that are closer than this count as one, s.
_TOGETHER_S = 0.05
#: How many intervals are kept.
_KEPT = 8


class PeriodLearner:
    """Learns a period from arrivals: the second longest of the last few intervals.

    A single gap does not change that. Nor do messages that a link has held back and delivers all at
    once, which would fool a mean or a median. A new period that is longer is learnt after two
    intervals, one that is shorter after seven.
    """

    def __init__(self) -> None:
        self._intervals: Deque[float] = collections.deque(maxlen=_KEPT)
        self._arrival: Optional[float] = None
        self._second = 0.0

    def add_arrival(self, now: float, longest: float) -> None:
        """Record an arrival.

        :param now: time, s
        :param longest: longest period that there may be, s; what is longer is an absence
        """
        if self._arrival is None:
            self._arrival = now
        elif now - self._arrival >= _TOGETHER_S:
            if now - self._arrival <= longest:
                self._intervals.append(now - self._arrival)
                if len(self._intervals) > 1:
                    self._second = sorted(self._intervals)[-2]
            self._arrival = now

    def period(self, longest: float) -> float:
        """Return the period, s.

        :param longest: longest period that there may be, s; returned before two intervals are known
        """
        return min(max(self._second, LEAST_PERIOD_S), longest) if self._second else longest
