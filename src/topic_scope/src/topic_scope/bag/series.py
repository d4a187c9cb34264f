"""Numbers from a bag over time, and what is computed of them."""

import math
from array import array
from typing import Collection, Iterable, List, NamedTuple, Optional, Tuple

import numpy

from topic_scope.bag.message_slices import Slice
from topic_scope.bag.column_reader import ColumnReader
from topic_scope.formulas.parser import Formula
from topic_scope.formulas.signals import Signal
from topic_scope.messages.derived import make
from topic_scope.messages.fields import FieldError, Path
from topic_scope.messages.timestamp_source import correction, longest_step, placed, said_in

#: Beyond this a plot of several such values would overflow.
_LARGEST = 1e300
#: Times of stamps are rounded to less than this [s].
_ROUNDED_S = 1e-5


class Series(NamedTuple):
    """A number over time.

    :param name: name of the field
    :param times: when each message was made, since the start of the bag [s]
    :param values: the number in each message; NaN for a message without one
    :param correction: how the stamps were moved, in words
    """

    name: str
    times: "array[float]"
    values: "array[float]"
    correction: Optional[str] = None

    @property
    def title(self) -> str:
        """The name, and what is to be known of the times."""
        return f"{self.name} ({self.correction})" if self.correction else self.name


class _Recorded:
    """Rows of a column: recording time, stamp and number of each message.

    :param reader: reads the column
    """

    def __init__(self, reader: ColumnReader) -> None:
        self._reader = reader
        self._received: List[numpy.ndarray] = [numpy.empty(0)]
        self._own: List[numpy.ndarray] = [numpy.empty(0)]
        self._rows: List[numpy.ndarray] = []

    def add(self, found: Slice) -> None:
        """Add the numbers in messages, but of those that are about elements of other names."""
        there = self._reader.about(found.messages)
        self._received.append(found.times[there] / 1e9)
        self._own.append(self._reader.stamps(found.messages)[there])
        self._rows.append(self._reader.rows(found.messages)[:, there])

    def series(self) -> Series:
        """Return all of it in the order of time; where the time was set back, the line ends."""
        times, values = array("d"), array("d")
        column, path = self._reader.column, self._reader.stamp_path
        if not self._rows:
            return Series(column.name, times, values)
        function, rows = make(column.function), numpy.concatenate(self._rows, axis=1)
        start, own = 0, numpy.concatenate(self._own)
        begin = self._reader.begin
        received = numpy.concatenate(self._received) + begin
        parts = placed(path, own, received, self._reader.is_exact)
        said = said_in(path, own)
        by = float(numpy.median((numpy.concatenate(parts) - own)[said])) if said.any() else 0.0
        words = correction(path, by if abs(by) > _ROUNDED_S else 0.0)
        path = path if said.any() else None
        for part in parts:
            if times:
                times.append(times[-1])
                values.append(math.nan)
            order = numpy.argsort(part, kind="stable")
            own_rows, longest = rows[:, start : start + len(part)], longest_step(path, part[order])
            made, found = function(part[order], own_rows[:, order], longest)
            found[~(numpy.abs(found) <= _LARGEST)] = numpy.nan
            made, found = _with_gaps(path, made, found)
            times.extend(made - begin)
            values.extend(found)
            start += len(order)
        return Series(column.name, times, values, words)


def _with_gaps(
    path: Optional[Path], times: numpy.ndarray, values: numpy.ndarray
) -> "Tuple[numpy.ndarray, numpy.ndarray]":
    """End the line wherever several samples are missing."""
    ends = numpy.flatnonzero(numpy.diff(times) > longest_step(path, times)) + 1
    return numpy.insert(times, ends, times[ends - 1]), numpy.insert(values, ends, numpy.nan)


def collect(readers: List[ColumnReader], slices: Iterable[List[Slice]]) -> List[Series]:
    """Gather the numbers in messages.

    :param readers: read the numbers, column by column
    :param slices: the messages
    :returns: a series for each column
    :raises struct.error: if a message is cut off
    """
    everything = [_Recorded(reader) for reader in readers]
    for found in slices:
        for one in found:
            for reader, recorded in zip(readers, everything):
                if reader.column.topic == one.topic:
                    recorded.add(one)
    return [recorded.series() for recorded in everything]


def computed(name: str, formula: Formula, everything: Collection[Series]) -> Series:
    """Return what a formula makes of series.

    :param name: of the result
    :param formula: the formula
    :param everything: the series that it is computed of, and perhaps others
    """
    signals = {}
    for series in everything:
        times, values = numpy.array(series.times), numpy.array(series.values)
        # Where a line ends a NaN stands, so none has to be found again.
        signals[series.name] = Signal(times, values, times, math.inf)
    times, values, *_ = formula.computed(signals)
    drawn = numpy.where(numpy.abs(values) <= _LARGEST, values, numpy.nan)
    words = (one.correction for one in everything if one.name in formula.fields and one.correction)
    return Series(name, array("d", times), array("d", drawn), next(words, None))


def moved(series: Series, seconds: float, name: str) -> Series:
    """Return a series later in time, under another name."""
    times = array("d", (time + seconds for time in series.times))
    return series._replace(name=name, times=times)


def crossing(series: Series, level: float) -> float:
    """Return when a series first rises through a level [s]: on the line between two points.

    :raises FieldError: if it never does
    """
    times, values = numpy.array(series.times), numpy.array(series.values)
    rising = numpy.flatnonzero((values[:-1] < level) & (values[1:] >= level))
    if not len(rising):
        raise FieldError(f"{series.name} does not rise through {level:g} in this time")
    before = int(rising[0])
    part = (level - values[before]) / (values[before + 1] - values[before])
    return float(times[before] + part * (times[before + 1] - times[before]))
