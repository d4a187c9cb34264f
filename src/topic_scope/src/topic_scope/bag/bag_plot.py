"""Plot numbers from a bag over time."""

import math
import textwrap
from array import array
from typing import Iterable, List, NamedTuple, Optional, Tuple

import matplotlib
import numpy
from cycler import cycler
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import TABLEAU_COLORS
from matplotlib.figure import Figure

from topic_scope.bag.bag_messages import Slice
from topic_scope.bag.column_reader import ColumnReader
from topic_scope.formulas.reading import Formula
from topic_scope.formulas.signals import Signal
from topic_scope.messages.derived import make
from topic_scope.messages.fields import Path
from topic_scope.messages.timestamp_source import longest_step, placed, said_in

#: Beyond this a plot of several such values would overflow.
_LARGEST = 1e300
#: So few points are marked, as a line through them may not be seen.
_MARKED = 40
#: Most characters in a line of the y axis's title.
_TITLE_WIDTH = 60

#: As many lines as four styles and ten colours tell apart.
_LINES = cycler(linestyle=["-", "--", ":", "-."]) * cycler(color=TABLEAU_COLORS.values())

_STYLE = {
    # Agg refuses to draw longer lines in one piece.
    "agg.path.chunksize": 20000,
    # The same picture gives the same file.
    "svg.hashsalt": "topic_scope",
}


class Series(NamedTuple):
    """A number over time.

    :param name: name of the field
    :param times: when each message was made, since the start of the bag, s
    :param values: the number in each message; NaN where there is none to plot
    """

    name: str
    times: "array[float]"
    values: "array[float]"


class _Recorded:
    """What is gathered of a column: when each message was recorded, what time it says, its number.

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
        parts = placed(path, own, numpy.concatenate(self._received), self._reader.is_exact)
        path = path if said_in(path, own).any() else None
        for part in parts:
            if times:
                times.append(times[-1])
                values.append(math.nan)
            order = numpy.argsort(part, kind="stable")
            own_rows, longest = rows[:, start : start + len(part)], longest_step(path, part[order])
            made, found = function(part[order], own_rows[:, order], longest)
            found[~(numpy.abs(found) <= _LARGEST)] = numpy.nan
            made, found = _with_gaps(path, made, found)
            times.extend(made)
            values.extend(found)
            start += len(order)
        return Series(column.name, times, values)


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


def computed(name: str, formula: Formula, everything: Iterable[Series]) -> Series:
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
    return Series(name, array("d", times), array("d", drawn))


def draw(everything: List[Series]) -> Figure:
    """Draw series over one time axis.

    :param everything: the series, at least one
    """
    with matplotlib.rc_context(_STYLE):
        height = 4.5 + 0.2 * (len(everything) // 2)
        figure = Figure(figsize=(9.0, height), dpi=150, constrained_layout=True)
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.set_prop_cycle(_LINES)
        for series in everything:
            few = sum(map(math.isfinite, series.values)) <= _MARKED
            axes.plot(series.times, series.values, marker="." if few else "", label=series.name)
        axes.set_xlabel("time [s]")
        axes.set_ylabel(_title([series.name for series in everything]))
        axes.grid(alpha=0.3)
        axes.margins(x=0.01)
        # On the right, as the left is where an axis writes its power of ten.
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=2, frameon=False, borderaxespad=0.2
        )
    return figure


def save(figure: Figure, path: str, format: str) -> None:
    """Write a drawing to a file.

    :param figure: the drawing
    :param path: the file
    :param format: ``png``, ``svg`` or ``pdf``
    """
    # Without a date, the same drawing gives the same file.
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(format)
    with matplotlib.rc_context(_STYLE):
        figure.savefig(path, format=format, metadata=metadata)


def _title(names: List[str]) -> str:
    text = ", ".join(names)
    lines = textwrap.wrap(text, _TITLE_WIDTH, max_lines=2, placeholder=" …")
    return "\n".join(lines)
