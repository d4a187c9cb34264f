# Pure: knows no ROS.
"""Median lag of a topic, from the stamps of its messages to their receipt, and its drift."""

from collections import deque
from typing import Deque, Tuple

import numpy

from topic_scope.timing.nanoseconds import NS

#: Time window of the median [ns].
RECENT_NS = 2 * NS
#: Change of the lag from which it is estimated again [ns]: at first, and once it has settled. The
#: latter is larger, so that load on the machine does not shift a trace.
TOLERANCE_NS, SETTLED_NS = 2 * NS // 1000, NS // 10
#: Most samples of a batch in the median, so that the cost of an update does not depend on the rate.
_SAMPLES = 64


class Lag:
    """Recent median of times of receipt minus stamps, and its drift.

    The lag drifts if a simulation or a replay is faster or slower than the scope's clock.

    :ivar usual: the median, at the latest time of receipt [ns]
    :ivar drift: its change per second [s/s]
    :ivar received: latest time of receipt [ns]
    :ivar is_settled: whether enough messages have been received
    """

    def __init__(self) -> None:
        self.usual = 0
        self.drift = 0.0
        self.received = 0
        self.is_settled = False
        self._at = 0
        self._settles_at = 0
        self._tolerance = TOLERANCE_NS
        self._recent: Deque[Tuple[numpy.ndarray, numpy.ndarray]] = deque()

    def expected(self, received: int) -> int:
        """Return the usual difference at a time of receipt [ns]."""
        return self.usual + round(self.drift * (received - self._at))

    def expected_of(self, received: numpy.ndarray) -> numpy.ndarray:
        """Return the usual difference at each time of receipt [ns]."""
        if not self.drift:
            return numpy.full(len(received), self.usual, numpy.int64)
        drifted = numpy.rint(self.drift * (received - self._at)).astype(numpy.int64)
        return numpy.asarray(drifted + self.usual)

    def stamps(self) -> numpy.ndarray:
        """Return the latest stamps [ns]."""
        return self.recent()[1]

    def recent(self) -> Tuple[numpy.ndarray, numpy.ndarray]:
        """Return the latest times of receipt and their stamps [ns]."""
        nothing = numpy.empty(0, numpy.int64)
        received = numpy.concatenate([nothing, *(times for times, _ in self._recent)])
        apart = numpy.concatenate([nothing, *(differences for _, differences in self._recent)])
        return received, received - apart

    def begin(self, usual: int, received: int) -> None:
        """Start with a difference [ns], before any message has confirmed it."""
        self.usual, self._at = usual, received
        self._settles_at = received + RECENT_NS

    def add(self, received: numpy.ndarray, differences: numpy.ndarray) -> bool:
        """Add messages.

        :param received: their times of receipt, ascending [ns]
        :param differences: these minus their stamps [ns]
        :returns: whether the usual difference has changed
        """
        step = -(-len(received) // _SAMPLES)
        self._recent.append((received[::step], differences[::step]))
        self.received = int(received[-1])
        while int(self._recent[0][0][-1]) < self.received - RECENT_NS:
            self._recent.popleft()
        settles = not self.is_settled and self.received >= self._settles_at
        is_near = numpy.abs(differences - self.usual).max() <= self._tolerance
        if is_near and not settles and not self.drift:
            return False  # the estimate still fits: save the time for the median
        before = self.usual
        self._estimate()
        if settles:
            self.is_settled, self._tolerance = True, SETTLED_NS
        return settles or self.usual != before

    def _estimate(self) -> None:
        times, differences = (numpy.concatenate(parts) for parts in zip(*self._recent))
        recent = times >= self.received - RECENT_NS
        times, differences = times[recent], differences[recent]
        half = len(times) // 2
        self._at, self.drift = self.received, 0.0
        if half:
            # A line through the medians of both halves is robust against outliers.
            early, late = median(differences[:half]), median(differences[half:])
            apart = median(times[half:]) - median(times[:half])
            if abs(late - early) > SETTLED_NS and apart > 0:
                self.drift = (late - early) / apart
                ahead = self.received - median(times[half:])
                self.usual = late + round(self.drift * ahead)
                return
        self.usual = median(differences)


def median(values: numpy.ndarray) -> int:
    """Return the lower median of integers, without rounding."""
    middle = (len(values) - 1) // 2
    return int(numpy.partition(values, middle)[middle])
