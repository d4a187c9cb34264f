"""Plot numbers from a bag over time."""

import math
import textwrap
from array import array
from typing import Dict, Iterable, List, NamedTuple, Optional, Tuple

import matplotlib
import numpy
from cycler import cycler
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import TABLEAU_COLORS
from matplotlib.figure import Figure

from topic_scope.analysis.xy import paired
from topic_scope.bag.bag_columns import Column
from topic_scope.bag.bag_reading import Sample
from topic_scope.messages.definitions import layout_of
from topic_scope.messages.derived import make, parts
from topic_scope.messages.fields import Key, Path
from topic_scope.messages.timestamp_source import longest_step, path_of, placed, said_in
from topic_scope.messages.values import getter, value_at

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
    :param times: when each message was made, since the begin of the bag, s
    :param values: the number in each message; NaN where there is none to plot
    """

    name: str
    times: "array[float]"
    values: "array[float]"


class _Recorded:
    """What is gathered of a column: when each message was recorded, what time it says, its number.

    :param column: the column
    """

    def __init__(self, column: Column) -> None:
        self._column = column
        self._is_named = any(isinstance(part, Key) for part in column.path)
        self._getters = [getter(column.path + part) for part in parts(column.function)]
        self._path: Optional[Path] = None
        self._received, self._own = array("d"), array("d")
        self._rows = [array("d") for _ in self._getters]

    def add(self, sample: Sample) -> None:
        """Take the number from a message, unless that is about elements of other names."""
        if self._is_named and value_at(sample.message, self._column.path) is None:
            return
        if not self._received:
            self._path = path_of(self._column.timestamp, layout_of(type(sample.message)))
        self._received.append(sample.time / 1e9)
        self._own.append(getter(self._path)(sample.message) if self._path else math.nan)
        for row, value in zip(self._rows, self._getters):
            row.append(value(sample.message))

    def series(self) -> Series:
        """Return all of it in the order of time; where the time was set back, the line ends."""
        times, values = array("d"), array("d")
        function, rows = make(self._column.function), numpy.array(self._rows)
        begin, own = 0, numpy.array(self._own)
        path = self._path if said_in(self._path, own).any() else None
        for part in placed(self._path, own, numpy.array(self._received)):
            if times:
                times.append(times[-1])
                values.append(math.nan)
            order = numpy.argsort(part, kind="stable")
            found = function(part[order], rows[:, begin : begin + len(part)][:, order])
            found[~(numpy.abs(found) <= _LARGEST)] = numpy.nan
            # What is computed of two begins with the second.
            late = len(order) - len(found)
            part, found = _with_gaps(path, part[order][late:], found)
            times.extend(part)
            values.extend(found)
            begin += len(order)
        return Series(self._column.name, times, values)


def _with_gaps(
    path: Optional[Path], times: numpy.ndarray, values: numpy.ndarray
) -> "Tuple[numpy.ndarray, numpy.ndarray]":
    """End the line wherever several samples are missing."""
    ends = numpy.flatnonzero(numpy.diff(times) > longest_step(path, times)) + 1
    return numpy.insert(times, ends, times[ends - 1]), numpy.insert(values, ends, numpy.nan)


def collect(columns: List[Column], samples: Iterable[Sample]) -> List[Series]:
    """Gather the numbers in messages.

    :param columns: which numbers
    :param samples: the messages
    :returns: a series for each column
    """
    everything = [_Recorded(column) for column in columns]
    by_topic: Dict[str, List[_Recorded]] = {}
    for column, recorded in zip(columns, everything):
        by_topic.setdefault(column.topic, []).append(recorded)
    for sample in samples:
        for recorded in by_topic.get(sample.topic, []):
            recorded.add(sample)
    return [recorded.series() for recorded in everything]


def difference(first: Series, second: Series) -> Series:
    """Return a series less another one on the straight line between two of its points."""
    points = (numpy.array(first.times), numpy.array(first.values))
    # Where a line ends a NaN stands, so none has to be found again.
    less, values = paired((numpy.array(second.times), numpy.array(second.values)), points, math.inf)
    apart = values - less
    apart[~(numpy.abs(apart) <= _LARGEST)] = numpy.nan
    return Series(f"{first.name}-{second.name}", first.times, array("d", apart))


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
