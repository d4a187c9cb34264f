# Pure: knows no ROS.
"""Usual time from the stamps of one topic to the reception of its messages."""

from collections import deque
from typing import Deque, Tuple

import numpy

from topic_scope.timing.nanoseconds import NS

#: How much of what was received counts for the median [ns].
RECENT_NS = 2 * NS
#: The lag is estimated again if it has changed by more than this [ns]: at first, and when enough
#: has been received. From then on a trace does not move for a machine that is busy.
TOLERANCE_NS, SETTLED_NS = 2 * NS // 1000, NS // 10
#: Most samples of a batch that count for the median, so that an update costs the same at any rate.
_SAMPLES = 64


class Lag:
    """Median of receptions minus stamps in the last seconds, and how it drifts.

    It drifts where a simulation or a replay is faster or slower than the scope's clock.

    :ivar usual: the median, at the latest reception [ns]
    :ivar drift: its change per second [s/s]
    :ivar received: the latest reception [ns]
    :ivar is_settled: whether enough was received
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
        """Return the usual difference at a time of reception [ns]."""
        return self.usual + round(self.drift * (received - self._at))

    def expected_of(self, received: numpy.ndarray) -> numpy.ndarray:
        """Return the usual difference at each time of reception [ns]."""
        if not self.drift:
            return numpy.full(len(received), self.usual, numpy.int64)
        drifted = numpy.rint(self.drift * (received - self._at)).astype(numpy.int64)
        return numpy.asarray(drifted + self.usual)

    def stamps(self) -> numpy.ndarray:
        """Return the latest stamps [ns]."""
        parts = [received - differences for received, differences in self._recent]
        return numpy.concatenate([numpy.empty(0, numpy.int64), *parts])

    def begin(self, usual: int, received: int) -> None:
        """Start with a difference [ns], before any message has confirmed it."""
        self.usual, self._at = usual, received
        self._settles_at = received + RECENT_NS

    def add(self, received: numpy.ndarray, differences: numpy.ndarray) -> bool:
        """Add messages.

        :param received: their times of reception, ascending [ns]
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
            return False  # nothing contradicts what is known: the median would take the time
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
            # A line through the middles of both halves: no few outliers bend it.
            early, late = median(differences[:half]), median(differences[half:])
            apart = median(times[half:]) - median(times[:half])
            if abs(late - early) > SETTLED_NS and apart > 0:
                self.drift = (late - early) / apart
                ahead = self.received - median(times[half:])
                self.usual = late + round(self.drift * ahead)
                return
        self.usual = median(differences)


def median(values: numpy.ndarray) -> int:
    """Return the lower median of whole numbers, without rounding them."""
    middle = (len(values) - 1) // 2
    return int(numpy.partition(values, middle)[middle])
