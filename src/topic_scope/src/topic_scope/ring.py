"""The recent samples of one trace, in memory that is bounded."""

from typing import Tuple

import numpy

#: Samples and their times, s.
Samples = Tuple[numpy.ndarray, numpy.ndarray]

#: Most samples of a trace that are kept: 16 MB.
LIMIT = 1 << 20
_SMALLEST = 1 << 10


class Ring:
    """Samples in the order of their times; the oldest are forgotten.

    :param history: how long a sample is kept, s
    :param limit: most samples that are kept
    """

    def __init__(self, history: float, limit: int = LIMIT) -> None:
        self._history = history
        self._limit = limit
        self._data = numpy.empty((2, min(_SMALLEST, 2 * limit)))
        self._start = self._end = 0

    def __len__(self) -> int:
        return self._end - self._start

    def append(self, times: numpy.ndarray, values: numpy.ndarray) -> None:
        """Add samples.

        :param times: when they came, ascending and none before those that are there, s
        :param values: what came
        """
        times, values = times[-self._limit :], values[-self._limit :]
        count = len(times)
        if not count:
            return
        self._forget(times[-1] - self._history, count)
        if self._end + count > self._data.shape[1]:
            self._make_room(count)
        self._data[0, self._end : self._end + count] = times
        self._data[1, self._end : self._end + count] = values
        self._end += count

    def between(self, start: float, end: float) -> Samples:
        """Return the samples of a time span, its ends included.

        :param start: begin of the span, s
        :param end: end of the span, s
        :returns: times and values; views that hold until samples are added
        """
        times = self._data[0, self._start : self._end]
        first = self._start + int(numpy.searchsorted(times, start, "left"))
        last = self._start + int(numpy.searchsorted(times, end, "right"))
        return self._data[0, first:last], self._data[1, first:last]

    def _forget(self, before: float, more: int) -> None:
        times = self._data[0, self._start : self._end]
        self._start += int(numpy.searchsorted(times, before, "left"))
        self._start = max(self._start, self._end + more - self._limit)

    def _make_room(self, count: int) -> None:
        """Move the samples to the front, of more memory where they fill half of it."""
        kept = self._data[:, self._start : self._end]
        capacity = self._data.shape[1]
        while capacity < 2 * (kept.shape[1] + count) and capacity < 2 * self._limit:
            capacity *= 2
        data = numpy.empty((2, max(capacity, kept.shape[1] + count)))
        data[:, : kept.shape[1]] = kept
        self._data, self._start, self._end = data, 0, kept.shape[1]
