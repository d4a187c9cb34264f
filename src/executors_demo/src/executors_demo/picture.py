# Pure: knows no ROS.
"""Timeline picture: a row for each thread, a bar for each call."""

from itertools import cycle
from typing import Dict, List, NamedTuple

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import TABLEAU_COLORS
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from executors_demo.bars import Bar

#: Width from which on a bar has room for its number, relative to the time axis.
_ROOM = 0.012
#: Least width of a bar, relative to the time axis, so that short calls are visible.
_THINNEST = 0.004
#: Most callback names in one line of the legend.
_COLUMNS = 8
#: Reproducible output: the same picture gives the same file.
_STYLE = {"svg.hashsalt": "executors_demo", "font.size": 8}


class Panel(NamedTuple):
    """Calls of one run.

    :param title: its title
    :param bars: the calls, at least one
    """

    title: str
    bars: List[Bar]


def draw(panels: List[Panel]) -> Figure:
    """Draw runs one below the other, with a common time axis.

    :param panels: the runs, at least one
    """
    rows = sum(len(_threads(panel)) + 2 for panel in panels)
    names = sorted({bar.who for panel in panels for bar in panel.bars})
    colours = dict(zip(names, cycle(TABLEAU_COLORS.values())))
    with matplotlib.rc_context(_STYLE):
        size = 8.0, 0.8 + 0.26 * rows
        figure = Figure(figsize=size, constrained_layout=True)
        FigureCanvasAgg(figure)
        grid = figure.subplots(
            len(panels),
            sharex=True,
            squeeze=False,
            gridspec_kw={"height_ratios": [len(_threads(panel)) + 1 for panel in panels]},
        )
        end = max(bar.end for panel in panels for bar in panel.bars) or 1.0
        for axes, panel in zip(grid[:, 0], panels):
            _draw_panel(axes, panel, colours, end)
        grid[-1, 0].set_xlabel("time since the start of the node, s")
        # Above the first panel, on the right.
        grid[0, 0].legend(
            handles=[Patch(color=colour, label=name) for name, colour in colours.items()],
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncol=min(len(colours), _COLUMNS),
            frameon=False,
            borderaxespad=0.2,
        )
    return figure


def _threads(panel: Panel) -> List[str]:
    return sorted({bar.thread for bar in panel.bars}, key=lambda name: (len(name), name))


def _draw_panel(axes: Axes, panel: Panel, colours: Dict[str, str], end: float) -> None:
    threads = _threads(panel)
    for bar in panel.bars:
        row, length = threads.index(bar.thread), bar.end - bar.begin
        axes.barh(
            row,
            max(length, _THINNEST * end),
            left=bar.begin,
            height=0.8,
            color=colours[bar.who],
            edgecolor="white",
            linewidth=0.5 if length > _THINNEST * end else 0.0,
        )
        if length > _ROOM * end:
            middle = bar.begin + length / 2
            axes.text(middle, row, str(bar.number), ha="center", va="center", color="white")
    axes.set_yticks(range(len(threads)))
    axes.set_yticklabels(threads)
    axes.set_ylim(len(threads) - 0.4, -0.6)
    axes.set_xlim(0.0, end)
    axes.set_title(panel.title, loc="left", fontsize=8)
    axes.grid(axis="x", alpha=0.3)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def save(figure: Figure, path: str, format: str) -> None:
    """Write a picture to a file.

    :param figure: the picture
    :param path: the file
    :param format: ``png`` or ``svg``
    """
    metadata = {"Date": None} if format == "svg" else None
    with matplotlib.rc_context(_STYLE):
        figure.savefig(path, format=format, metadata=metadata, dpi=150)
