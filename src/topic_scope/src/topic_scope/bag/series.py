"""Time series of numbers and states, collected from a bag's messages or computed by formulas."""

import itertools
import math
from array import array
from typing import Collection, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import numpy

from topic_scope.bag.message_slices import Slice
from topic_scope.bag.column_reader import ColumnReader
from topic_scope.formulas.parser import Formula
from topic_scope.formulas.signals import Signal
from topic_scope.messages.field_functions import make
from topic_scope.messages.fields import FieldError, Path
from topic_scope.messages.timestamp_source import longest_step, oddities
from topic_scope.timing.clocks import Clocks
from topic_scope.timing.nanoseconds import NS, array_to_ns
from topic_scope.timing.topic_time import PlacedMessages

#: Larger values would overflow in a plot.
_LARGEST = 1e300
#: Part of a bag that determines the offset of its stamps' clock from the recorder's clock [ns].
OFFSET_NS = 3 * NS


class Series(NamedTuple):
    """Number or state over time.

    :param name: name of the field
    :param times: timestamp of each message, since the start of the bag [s]
    :param values: the number in each message; NaN if missing
    :param correction: description of shifted stamps and rounded values
    :param states: texts of the state numbers in ``values``; None for numbers
    """

    name: str
    times: "array[float]"
    values: "array[float]"
    correction: Optional[str] = None
    states: Optional[Sequence[str]] = None

    @property
    def title(self) -> str:
        """The name, and the correction."""
        return f"{self.name} ({self.correction})" if self.correction else self.name


class _Placement:
    """Placement of the messages of one topic in time, in order of reading.

    :param clocks: the clocks of all topics of the bag
    :param reader: reader of the stamps
    """

    def __init__(self, clocks: Clocks, reader: ColumnReader) -> None:
        self._reader = reader
        self.time = reader.topic_time(clocks)
        self._placed: List[PlacedMessages] = []
        self._own = self._received = numpy.empty(0, numpy.int64)

    def add(self, found: Slice) -> None:
        """Add the next messages."""
        self._own = numpy.concatenate([self._own, self._reader.stamps(found.messages)])
        self._received = numpy.concatenate([self._received, found.times + self._reader.begin])
        self._place(False)

    def _place(self, is_final: bool) -> None:
        placed = self.time.place(self._own, self._received, is_final)
        count = sum(len(one.times) for one in placed)
        self._own, self._received = self._own[count:], self._received[count:]
        self._placed += placed

    def finish(self) -> None:
        """Place the last messages, without waiting for others that confirm their clock."""
        self._place(True)

    def pieces(self) -> List[numpy.ndarray]:
        """Return the timestamps of the messages, since the start of the bag [ns].

        :returns: an array for each stretch between settings of the clock
        """
        pieces = []
        for clock, parts in itertools.groupby(self._placed, key=lambda one: one.clock):
            times = numpy.concatenate([one.times for one in parts])
            pieces.append(times + (clock.offset - self._reader.begin))
        return pieces


class _Recorded:
    """Collected rows of a column.

    :param reader: reader of the column
    :param placement: placement of its messages in time
    """

    def __init__(self, reader: ColumnReader, placement: _Placement) -> None:
        self.placement = placement
        self._reader = reader
        self._there: List[numpy.ndarray] = []
        self._rows: List[numpy.ndarray] = []

    def add(self, found: Slice) -> None:
        """Add the numbers in messages, except messages about other named elements."""
        there = self._reader.about(found.messages)
        self._there.append(there)
        self._rows.append(self._reader.rows(found.messages)[:, there])

    def series(self) -> Series:
        """Return the series in time order; the line ends where the clock was set."""
        times, values = array("d"), array("d")
        column, time = self._reader.column, self.placement.time
        if not self._rows:
            return Series(column.name, times, values, None, self._texts)
        function, rows = make(column.function), numpy.concatenate(self._rows, axis=1)
        there = numpy.concatenate(self._there)
        path = self._reader.stamp_path if time.has_stamps else None
        start = first = 0
        for piece in self.placement.pieces():
            moments = piece[there[start : start + len(piece)]]
            start += len(piece)
            if times:
                times.append(times[-1])
                values.append(math.nan)
            order = numpy.argsort(moments, kind="stable")
            own_rows = rows[:, first : first + len(moments)]
            first += len(moments)
            longest = longest_step(path, moments[order])
            made, found = function(moments[order], own_rows[:, order], longest)
            found[~(numpy.abs(found) <= _LARGEST)] = numpy.nan
            if self._texts is None:  # a state holds until the next message
                made, found = _with_gaps(path, made, found)
            times.extend(made / NS)
            values.extend(found)
        texts = oddities(self._reader.stamp_path, time), self._reader.correction
        words = "; ".join(filter(None, texts)) or None
        return Series(column.name, times, values, words, self._texts)

    @property
    def _texts(self) -> Optional[Sequence[str]]:
        return self._reader.states.texts if self._reader.states is not None else None


def _with_gaps(
    path: Optional[Path], times: numpy.ndarray, values: numpy.ndarray
) -> "Tuple[numpy.ndarray, numpy.ndarray]":
    """End the line at gaps of several samples."""
    ends = numpy.flatnonzero(numpy.diff(times) > longest_step(path, times) * NS) + 1
    return numpy.insert(times, ends, times[ends - 1]), numpy.insert(values, ends, numpy.nan)


def collect(readers: List[ColumnReader], slices: Iterable[List[Slice]]) -> List[Series]:
    """Collect the numbers in messages.

    :param readers: readers of the columns
    :param slices: the messages
    :returns: a series for each column
    """
    clocks = Clocks(OFFSET_NS)
    placements: Dict[Tuple[str, str], _Placement] = {}
    everything = []
    for reader in readers:
        key = reader.column.topic, reader.column.timestamp
        placement = placements.setdefault(key, _Placement(clocks, reader))
        everything.append(_Recorded(reader, placement))
    for found in slices:
        for one in found:
            for (topic, _), placement in placements.items():
                if topic == one.topic:
                    placement.add(one)
            for recorded, reader in zip(everything, readers):
                if reader.column.topic == one.topic:
                    recorded.add(one)
    for placement in placements.values():
        placement.finish()
    return [recorded.series() for recorded in everything]


def computed(name: str, formula: Formula, everything: Collection[Series]) -> Series:
    """Evaluate a formula on series.

    :param name: name of the result
    :param formula: the formula
    :param everything: the series of its fields, and perhaps others
    """
    signals = {}
    for series in everything:
        times, values = array_to_ns(numpy.array(series.times)), numpy.array(series.values)
        # NaNs already mark the ends of lines, so gaps need not be detected again.
        signals[series.name] = Signal(times, values, times, math.inf)
    times, values, *_ = formula.computed(signals)
    drawn = numpy.where(numpy.abs(values) <= _LARGEST, values, numpy.nan)
    words = (one.correction for one in everything if one.name in formula.fields and one.correction)
    return Series(name, array("d", times / NS), array("d", drawn), next(words, None))


def moved(series: Series, seconds: float, name: str) -> Series:
    """Return a series shifted to later times, under another name."""
    times = array("d", (time + seconds for time in series.times))
    return series._replace(name=name, times=times)


def crossing(series: Series, level: float) -> float:
    """Return the interpolated time at which a series first rises through a level [s].

    :raises FieldError: if it never does, or is a state
    """
    if series.states is not None:
        raise FieldError(f"{series.name} is a state, which cannot rise through a level")
    times, values = numpy.array(series.times), numpy.array(series.values)
    rising = numpy.flatnonzero((values[:-1] < level) & (values[1:] >= level))
    if not len(rising):
        raise FieldError(f"{series.name} does not rise through {level:g} in this time")
    before = int(rising[0])
    part = (level - values[before]) / (values[before + 1] - values[before])
    return float(times[before] + part * (times[before + 1] - times[before]))
