"""Streams of samples: which are missing, and how long a stream was silent."""

from typing import Optional, Sequence

import numpy as np

#: A longer silence counts as a gap [s]; a stalled subscriber may cost that much, once.
GAP = 0.05


class Arrivals:
    """Figures of a stream, updated message by message in constant memory."""

    def __init__(self) -> None:
        self.count = 0
        self.latest: Optional[float] = None
        #: longest silence [s]
        self.longest_gap = 0.0
        #: number of silences longer than GAP
        self.gaps = 0

    def add(self, moment: float, messages: int = 1) -> None:
        """Add messages that arrived together at a moment of a monotonic clock [s]."""
        if self.latest is not None:
            gap = moment - self.latest
            self.longest_gap = max(self.longest_gap, gap)
            self.gaps += gap > GAP
        self.latest = moment
        self.count += messages

    def __str__(self) -> str:
        """Return the longest silence and the number of gaps in words."""
        text = "%.1f ms at most, %d above %g ms"
        return text % (1e3 * self.longest_gap, self.gaps, 1e3 * GAP)


class Continuity:
    """Count of the samples that are missing between the first and the last one.

    :param period: from one sample to the next [s]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._latest: Optional[float] = None
        self.missing = 0
        #: samples whose time is that of the one before, or earlier
        self.repeated = 0

    def add(self, time_x: float) -> None:
        """Add the next sample, by its own time [s]."""
        if self._latest is not None:
            steps = round((time_x - self._latest) / self._period)
            if steps < 1:
                self.repeated += 1
            elif steps > 1:
                self.missing += steps - 1
        self._latest = time_x


def unanswered(expected: Sequence[float], answers: Sequence[float], window: int = 400) -> int:
    """Return how many samples have no answer, between the first answered one and the last one.

    The answers come in the order of the samples, so each missing one moves those after it.

    :param expected: the answer to each sample
    :param answers: those that came; either list may begin and end before the other
    :param window: how far apart the lists may begin and end
    :raises ValueError: if the answers do not belong to the samples
    """
    begin = _offset(expected, answers, window)
    end = _offset(expected[::-1], answers[::-1], window)
    samples = len(expected) - max(begin, 0) - max(end, 0)
    return samples - (len(answers) - max(-begin, 0) - max(-end, 0))


def _offset(expected: Sequence[float], answers: Sequence[float], window: int) -> int:
    """Return by how many places the second list begins later than the first."""
    for sign, long, short in ((1, expected, answers), (-1, answers, expected)):
        part, whole = np.asarray(short[:window]), np.asarray(long[: 2 * window])
        places = min(window, len(long) - len(part)) + 1 if len(part) else 0
        errors = [np.abs(whole[n : n + len(part)] - part).max() for n in range(places)]
        if errors and min(errors) < 1e-4:
            return sign * int(np.argmin(errors))
    raise ValueError("the answers do not belong to these samples")
