"""Draw numbers from a bag over time."""

import math
import textwrap
from typing import List

import matplotlib
from cycler import cycler
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import TABLEAU_COLORS
from matplotlib.figure import Figure

from topic_scope.bag.series import Series

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
            axes.plot(series.times, series.values, marker="." if few else "", label=series.title)
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
