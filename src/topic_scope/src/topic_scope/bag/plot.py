"""Matplotlib plot of a bag's time series: numbers as lines, states as coloured bands."""

import math
import textwrap
import zlib
from typing import List, Tuple

import matplotlib
import numpy
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import TABLEAU_COLORS
from matplotlib.figure import Figure

from topic_scope.analysis.state_spans import SEVERAL, state_spans
from topic_scope.bag.series import Series
from topic_scope.timing.nanoseconds import NS, array_to_ns, to_ns

#: Up to this number of points, points are marked: a line through them may be invisible.
_MARKED = 40
#: Most characters in a line of the y axis's title.
_TITLE_WIDTH = 60

#: Height of a state's band, width of the picture, width of a letter [in].
_BAND, _WIDTH, _LETTER = 0.7, 9.0, 0.08
#: Most spans of a band that are drawn individually.
_SPANS = 1000
_SEVERAL_COLOUR = "lightgrey"

#: Number of lines that four styles and ten colours distinguish.
_LINES = cycler(linestyle=["-", "--", ":", "-."]) * cycler(color=TABLEAU_COLORS.values())

_STYLE = {
    # Agg cannot draw longer lines in one piece.
    "agg.path.chunksize": 20000,
    # Identical pictures give identical files.
    "svg.hashsalt": "topic_scope",
}


def draw(everything: List[Series]) -> Figure:
    """Draw series over one time axis.

    :param everything: the series, at least one
    """
    lines = [series for series in everything if series.states is None]
    bands = [series for series in everything if series.states is not None]
    with matplotlib.rc_context(_STYLE):
        heights = [4.5 + 0.2 * (len(lines) // 2)] * bool(lines) + [_BAND] * len(bands)
        height = sum(heights) + (0.0 if lines else _BAND)
        figure = Figure(figsize=(_WIDTH, height), dpi=150, constrained_layout=True)
        FigureCanvasAgg(figure)
        rows = list(
            figure.subplots(
                len(heights), squeeze=False, sharex=True, gridspec_kw={"height_ratios": heights}
            )[:, 0]
        )
        rows[-1].set_xlabel("time [s]")
        if bands:
            _draw_bands(rows[-len(bands) :], bands, _span_of(everything))
        if lines:
            _draw_lines(rows[0], lines)
    return figure


def _draw_lines(axes: Axes, lines: List[Series]) -> None:
    axes.set_prop_cycle(_LINES)
    for series in lines:
        few = sum(map(math.isfinite, series.values)) <= _MARKED
        axes.plot(series.times, series.values, marker="." if few else "", label=series.title)
    axes.set_ylabel(_title([series.name for series in lines]))
    axes.grid(alpha=0.3)
    axes.margins(x=0.01)
    # On the right: the axis writes its power of ten on the left.
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=2, frameon=False, borderaxespad=0.2
    )


def _span_of(everything: List[Series]) -> Tuple[float, float]:
    """Return the first and the last time of all series [s]."""
    times = [time for series in everything for time in (*series.times[:1], *series.times[-1:])]
    return min(times, default=0.0), max(times, default=0.0)


def _draw_bands(rows: List[Axes], bands: List[Series], span: Tuple[float, float]) -> None:
    """Draw states as bands, coloured by their texts, with the text inside if it fits."""
    first, last = span
    whole = max(last - first, 1e-9)
    for axes, series in zip(rows, bands):
        axes.set_title(series.title, loc="left", fontsize="medium", pad=2.0)
        axes.set_yticks([])
        axes.set_ylim(0.0, 1.0)
        axes.set_xlim(first - 0.01 * whole, last + 0.01 * whole)
        texts, times = series.states or (), array_to_ns(numpy.array(series.times))
        width = max(to_ns(whole / _SPANS), 1)
        for one in state_spans(times, numpy.array(series.values), to_ns(-math.inf), width, _SPANS):
            text = f"{one.states} states" if one.number == SEVERAL else texts[one.number]
            start, end = one.start / NS, last if one.end is None else one.end / NS
            colour = _SEVERAL_COLOUR if one.number == SEVERAL else _colour_of(text)
            axes.axvspan(start, end, facecolor=colour, alpha=0.6, edgecolor="white")
            if len(text) * _LETTER < (end - start) / whole * _WIDTH and text.isprintable():
                # Escaped: a dollar sign would start a formula.
                middle = (start + end) / 2
                axes.text(middle, 0.5, text, ha="center", va="center", parse_math=False)


def _colour_of(text: str) -> str:
    """Return the colour of a text: the same in each picture."""
    colours = list(TABLEAU_COLORS.values())
    return str(colours[zlib.crc32(text.encode()) % len(colours)])


def save(figure: Figure, path: str, format: str) -> None:
    """Write a drawing to a file.

    :param figure: the drawing
    :param path: the file
    :param format: ``png``, ``svg`` or ``pdf``
    """
    # Without a date, identical drawings give identical files.
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(format)
    with matplotlib.rc_context(_STYLE):
        figure.savefig(path, format=format, metadata=metadata)


def _title(names: List[str]) -> str:
    text = ", ".join(names)
    lines = textwrap.wrap(text, _TITLE_WIDTH, max_lines=2, placeholder=" …")
    return "\n".join(lines)
