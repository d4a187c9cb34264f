"""Period of recurring messages, learnt from their arrival times."""

import collections
from typing import Deque, Optional

#: Shortest period [s]: a busy machine delays messages by as much.
LEAST_PERIOD_S = 0.1
#: Arrivals closer than this count as one [s].
_TOGETHER_S = 0.05
#: Number of intervals kept.
_KEPT = 8


class PeriodLearner:
    """Learner of a period: the second longest of the last few intervals.

    It is robust against a single gap, and against messages that a connection has held back and
    delivers together, which would distort a mean or a median. A longer period is learnt after two
    intervals, a shorter one after seven.
    """

    def __init__(self) -> None:
        self._intervals: Deque[float] = collections.deque(maxlen=_KEPT)
        self._arrival: Optional[float] = None
        self._second = 0.0

    def add_arrival(self, now: float, longest: float) -> None:
        """Record an arrival.

        :param now: time [s]
        :param longest: longest valid period [s]; a longer interval is an absence
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
        """Return the period [s].

        :param longest: longest valid period [s]; returned before two intervals are known
        """
        return min(max(self._second, LEAST_PERIOD_S), longest) if self._second else longest
