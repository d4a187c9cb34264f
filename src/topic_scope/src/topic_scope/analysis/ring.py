"""The recent samples of one trace, in memory that is bounded."""

import math
from typing import Optional, Tuple

import numpy

#: Samples and their times [s].
Samples = Tuple[numpy.ndarray, numpy.ndarray]

#: Most samples of a trace that are kept: 24 MB.
LIMIT = 1 << 20
_SMALLEST = 1 << 10
#: Memory for more than this many times what there is goes back, as when a topic is slower now.
_SPARE = 16


class Ring:
    """Samples in the order of their times, and when they were received; the oldest are forgotten.

    :param history: how long a sample is kept [s]
    :param limit: most samples that are kept

    :ivar history: as above
    :ivar has_forgotten: whether there were samples before those that are kept
    """

    def __init__(self, history: float, limit: int = LIMIT) -> None:
        self.history = history
        self.has_forgotten = False
        self._limit = limit
        self._data = numpy.empty((3, min(_SMALLEST, 2 * limit)))
        self._start = self._end = 0
        #: A span whose samples are kept all the same [s]; and those of them that were forgotten.
        self._pinned = (math.inf, -math.inf)
        self._kept: Optional["Ring"] = None

    def __len__(self) -> int:
        return self._end - self._start

    def append(self, times: numpy.ndarray, values: numpy.ndarray, received: numpy.ndarray) -> None:
        """Add samples; those that are late are sorted in.

        :param times: when they were taken [s]
        :param values: what was taken
        :param received: when they were received [s]
        """
        added = numpy.array([times, values, received])
        here = self._data[0, self._start : self._end]
        times = numpy.concatenate([here[-1:], added[0]])
        if (times[1:] < times[:-1]).any():
            late = self._start + int(here.searchsorted(added[0].min(), "right"))
            added = numpy.hstack([self._data[:, late : self._end], added])
            added = added[:, added[0].argsort(kind="stable")]
            self._end = late
        self._append(added[:, -self._limit :])

    def _append(self, added: numpy.ndarray) -> None:
        """Add samples in the order of their times, none before those that are there."""
        count = added.shape[1]
        if not count:
            return
        self._forget(added[0, -1] - self.history, count)
        capacity = self._data.shape[1]
        if self._end + count > capacity or capacity > max(_SMALLEST, _SPARE * (len(self) + count)):
            self._make_room(count)
        self._data[:, self._end : self._end + count] = added
        self._end += count

    def move(self, by: float) -> None:
        """Move all samples in time, and end the line that they make.

        :param by: how far [s]
        """
        start, end = self._pinned
        self._pinned = (start + by, end + by)
        for ring in [self] if self._kept is None else [self, self._kept]:
            ring._data[0, ring._start : ring._end] += by
        if len(self):
            gap = self._data[:, self._end - 1 : self._end].copy()
            gap[1] = numpy.nan
            self._append(gap)

    def between(self, start: float, end: float) -> numpy.ndarray:
        """Return the samples of a time span, its ends included.

        :param start: start of the span [s]
        :param end: end of the span [s]
        :returns: times, values and times of receipt; views that hold until samples are added
        """
        found = _between(self._data[:, self._start : self._end], start, end)
        kept = None if self._kept is None else self._kept.between(start, end)
        if kept is None or not kept.shape[1]:
            return found
        both = numpy.hstack([kept, found])
        if not found.shape[1] or kept[0, -1] <= found[0, 0]:
            return both
        return both[:, both[0].argsort(kind="stable")]  # what is late is among the recent at first

    def pin(self, start: float, end: float) -> None:
        """Keep the samples of a time span, also those to come, and no others, beyond their time.

        :param start: start of the span [s]
        :param end: end of the span [s]; before its begin to keep nothing
        """
        kept, self._kept = self._kept, None
        self._pinned = (start, end)
        if kept is not None:
            self._keep(kept.between(start, end))

    def latest(self, count: int) -> numpy.ndarray:
        """Return the times of the latest samples [s].

        :param count: how many at most
        """
        return self._data[0, max(self._start, self._end - count) : self._end]

    @property
    def last_received(self) -> Optional[float]:
        """Reception time of the latest sample [s]; None if empty."""
        return float(self._data[2, self._end - 1]) if len(self) else None

    def _forget(self, before: float, more: int) -> None:
        first, times = self._start, self._data[0, self._start : self._end]
        self._start += int(times.searchsorted(before, "left"))
        self._start = max(self._start, self._end + more - self._limit)
        if self._start > first:
            self.has_forgotten = True
            self._keep(_between(self._data[:, first : self._start], *self._pinned))

    def _keep(self, forgotten: numpy.ndarray) -> None:
        """Keep dropped samples that belong to the pinned span."""
        if forgotten.shape[1]:
            if self._kept is None:
                self._kept = Ring(math.inf, self._limit)
            self._kept.append(*forgotten)

    def _make_room(self, count: int) -> None:
        """Move the samples to the front, of other memory where that is full, or almost empty."""
        kept = self._data[:, self._start : self._end]
        needed, capacity = kept.shape[1] + count, self._data.shape[1]
        if capacity > _SPARE * needed:
            capacity = min(capacity, _SMALLEST)
        while capacity < 2 * needed and capacity < 2 * self._limit:
            capacity *= 2
        capacity = max(capacity, needed)
        # In its place where that does: memory that is taken and given back again and again tears.
        data = self._data if capacity == self._data.shape[1] else numpy.empty((3, capacity))
        data[:, : kept.shape[1]] = kept
        self._data, self._start, self._end = data, 0, kept.shape[1]


def _between(samples: numpy.ndarray, start: float, end: float) -> numpy.ndarray:
    times = samples[0]  # its own method: a call of numpy's function takes three times as long
    return samples[:, times.searchsorted(start, "left") : times.searchsorted(end, "right")]
