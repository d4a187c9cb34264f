"""Ring buffer of the recent samples of one trace."""

from typing import Optional, Tuple

import numpy

from topic_scope.timing.nanoseconds import NO_TIME, to_ns

#: Samples and their times [s].
Samples = Tuple[numpy.ndarray, numpy.ndarray]
#: Times of samples [ns], their values, and when they were received [ns].
Rows = Tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]

#: Empty time span.
NOWHERE = -NO_TIME, NO_TIME

#: Most samples kept for a trace: 24 MB.
LIMIT = 1 << 20
_SMALLEST = 1 << 10
#: Memory is released when the capacity exceeds the content by this factor (the topic slowed down).
_SPARE = 16
#: The most recently received sample is searched for in this number of latest samples.
_RECENT = 64


class Ring:
    """Ring buffer of samples in time order, with their receipt times; drops the oldest.

    :param history: how long a sample is kept [s]
    :param limit: most samples to keep

    :ivar history: as above
    :ivar has_forgotten: whether samples have been dropped
    """

    def __init__(self, history: float, limit: int = LIMIT) -> None:
        self.history = history
        self.has_forgotten = False
        self._kept_ns = to_ns(history)
        self._limit = limit
        capacity = min(_SMALLEST, 2 * limit)
        self._rows: Rows = _empty(capacity)
        self._start = self._end = 0
        #: The pinned span [ns], and its samples that left the ring.
        self._pinned = NOWHERE
        self._kept: Optional["Ring"] = None

    def __len__(self) -> int:
        return self._end - self._start

    def append(
        self,
        times: numpy.ndarray,
        values: numpy.ndarray,
        received: numpy.ndarray,
        newest: Optional[int] = None,
    ) -> None:
        """Add samples; late samples are sorted in.

        :param times: when they were taken [ns]
        :param values: the values
        :param received: when they were received [ns]
        :param newest: time that the history is counted from [ns]; None for the time of the
            latest sample
        """
        added: Rows = (times, values, received)
        here = self._rows[0][self._start : self._end]
        in_order = not len(here) or not len(times) or times[0] >= here[-1]
        if not in_order or (times[1:] < times[:-1]).any():
            late = self._start + int(here.searchsorted(times.min(), "right"))
            tail = slice(late, self._end)
            times = numpy.concatenate([self._rows[0][tail], times])
            order = times.argsort(kind="stable")
            added = (
                times[order],
                numpy.concatenate([self._rows[1][tail], values])[order],
                numpy.concatenate([self._rows[2][tail], received])[order],
            )
            self._end = late
        last = slice(-self._limit, None)
        self._append((added[0][last], added[1][last], added[2][last]), newest)

    def _append(self, added: Rows, newest: Optional[int] = None) -> None:
        """Add samples in time order, none before the existing ones."""
        count = len(added[0])
        if not count:
            return
        latest = int(added[0][-1])
        self._forget((latest if newest is None else min(newest, latest)) - self._kept_ns, count)
        capacity = len(self._rows[0])
        if self._end + count > capacity or capacity > max(_SMALLEST, _SPARE * (len(self) + count)):
            self._make_room(count)
        for row, new in zip(self._rows, added):
            row[self._end : self._end + count] = new
        self._end += count

    def move(self, by: int) -> None:
        """Shift all samples in time, and end their line.

        :param by: the shift [ns]
        """
        start, end = self._pinned
        if self._pinned != NOWHERE:
            self._pinned = (start + by, end + by)
        for ring in [self] if self._kept is None else [self, self._kept]:
            ring._rows[0][ring._start : ring._end] += by
        if len(self):
            time, _, received = self._part(self._end - 1, self._end)
            self._append((time.copy(), numpy.array([numpy.nan]), received.copy()))

    def between(self, start: int, end: int) -> Rows:
        """Return the samples of a time span, its ends included.

        :param start: start of the span [ns]
        :param end: end of the span [ns]
        :returns: times, values and receipt times; views that are valid until samples are added
        """
        found = self._between(start, end)
        kept = None if self._kept is None else self._kept.between(start, end)
        if kept is None or not len(kept[0]):
            return found
        times, values, received = (numpy.concatenate(both) for both in zip(kept, found))
        if not len(found[0]) or kept[0][-1] <= found[0][0]:
            return times, values, received
        order = times.argsort(kind="stable")  # late samples, still in the ring, may precede pinned
        return times[order], values[order], received[order]

    def pin(self, start: int, end: int) -> None:
        """Keep the samples of a time span, future ones included, beyond the history.

        :param start: start of the span [ns]
        :param end: end of the span [ns]; before its start to pin nothing
        """
        kept, self._kept = self._kept, None
        self._pinned = (start, end)
        if kept is not None:
            self._keep(kept.between(start, end))

    def latest(self, count: int) -> numpy.ndarray:
        """Return the times of the latest samples [ns].

        :param count: how many at most
        """
        return self._rows[0][max(self._start, self._end - count) : self._end]

    @property
    def last_received(self) -> Optional[int]:
        """Latest reception of the recent samples [ns]; None if empty."""
        if not len(self):
            return None
        return int(self._rows[2][max(self._start, self._end - _RECENT) : self._end].max())

    def _part(self, first: int, last: int) -> Rows:
        times, values, received = self._rows
        return times[first:last], values[first:last], received[first:last]

    def _between(self, start: int, end: int) -> Rows:
        # The array's own method: numpy's function takes three times as long.
        times = self._rows[0][self._start : self._end]
        first = self._start + int(times.searchsorted(start, "left"))
        return self._part(first, self._start + int(times.searchsorted(end, "right")))

    def _forget(self, before: int, more: int) -> None:
        first, times = self._start, self._rows[0][self._start : self._end]
        self._start += int(times.searchsorted(before, "left"))
        self._start = max(self._start, self._end + more - self._limit)
        if self._start > first:
            self.has_forgotten = True
            begin, end = self._pinned
            if begin <= end:
                forgotten = self._part(first, self._start)
                inside = slice(
                    forgotten[0].searchsorted(begin, "left"),
                    forgotten[0].searchsorted(end, "right"),
                )
                times, values, received = forgotten
                self._keep((times[inside], values[inside], received[inside]))

    def _keep(self, forgotten: Rows) -> None:
        """Keep dropped samples that belong to the pinned span."""
        if len(forgotten[0]):
            if self._kept is None:
                self._kept = Ring(numpy.inf, self._limit)
            self._kept.append(*forgotten)

    def _make_room(self, count: int) -> None:
        """Move the samples to the front; reallocate if the memory is full or almost empty."""
        kept = self._part(self._start, self._end)
        size = len(kept[0])
        needed, before = size + count, len(self._rows[0])
        capacity = before
        if capacity > _SPARE * needed:
            capacity = min(capacity, _SMALLEST)
        while capacity < 2 * needed and capacity < 2 * self._limit:
            capacity *= 2
        capacity = max(capacity, needed)
        # In place if possible: repeated allocation fragments memory.
        rows = self._rows if capacity == before else _empty(capacity)
        for row, old in zip(rows, kept):
            row[:size] = old
        self._rows, self._start, self._end = rows, 0, size


def _empty(capacity: int) -> Rows:
    times, received = (numpy.empty(capacity, numpy.int64) for _ in range(2))
    return times, numpy.empty(capacity), received
