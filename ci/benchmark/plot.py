"""The results as a picture: the hop's latency by stack, and each goal's value beside its limit."""

import pathlib
from typing import Any, List, Tuple

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

from .floor import FLOOR  # noqa: E402
from .goals import GOALS, Outcome, number  # noqa: E402
from .report import RATES  # noqa: E402
from .results import Results  # noqa: E402

COLORS = {Outcome.PASS: "#2a7f62", Outcome.SHORT: "#c8553d"}
UNSURE = "grey"
SHADES = {"p50": "#2b4c7e", "p90": "#567ebb", "p99": "#b3c7e6"}
#: A value this much better than its limit is drawn at the edge.
EDGE = 100.0


def draw(file: pathlib.Path, results: Results) -> None:
    """Draw what there is.

    :param file: its suffix tells the format
    """
    hops = [
        (measurement, subject, f"{subject}, {rate}")
        for measurement, rate in RATES
        for name, subject in results.subjects()
        if name == measurement and subject != FLOOR  # nothing is observed of that
    ]
    margins = _margins(results)
    height = 1.6 + 0.3 * max(len(hops), len(margins), 4)
    matplotlib.rcParams.update({"font.size": 9, "svg.hashsalt": "bench", "svg.fonttype": "none"})
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12.0, height))
    _draw_hops(left, results, hops)
    _draw_margins(right, margins)
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
        axes.invert_yaxis()
    figure.tight_layout()
    figure.savefig(str(file), dpi=120)
    pyplot.close(figure)


def _draw_hops(axes: Any, results: Results, hops: List[Tuple[str, str, str]]) -> None:
    for shade, offset in zip(SHADES, (-0.26, 0.0, 0.26)):
        values = [results.median(name, subject, shade + "_us") for name, subject, _ in hops]
        places = [place + offset for place in range(len(hops))]
        axes.barh(places, values, height=0.24, color=SHADES[shade], label=shade)
        for place, value in zip(places, values):
            axes.text(1.05 * value, place, number(value), va="center", fontsize=6)
    axes.set_yticks(range(len(hops)))
    axes.set_yticklabels([label for _, _, label in hops])
    axes.set_title("generator -> process -> observer, us", loc="left")
    if hops:
        axes.set_xscale("log")
        axes.set_xlim(left=20.0)  # below lies what two wake-ups of the kernel take anyway
        axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7)


def _margins(results: Results) -> List[Tuple[str, float, Outcome]]:
    """Return what, how many times better than its limit, and what came of it."""
    margins = []
    for goal in GOALS:
        verdict = goal.judge(results)
        if verdict is not None:
            low, high = sorted((abs(verdict.value), goal.limit))
            times = high / low if low else EDGE
            better = (verdict.value <= goal.limit) == goal.at_most
            margins.append((goal.what, times if better else 1.0 / times, verdict.outcome))
    return margins


def _draw_margins(axes: Any, margins: List[Tuple[str, float, Outcome]]) -> None:
    for place, (_, times, outcome) in enumerate(margins):
        end = min(max(times, 0.1), EDGE)
        color = COLORS.get(outcome, UNSURE)
        axes.plot([1.0, end], [place, place], color=color, linewidth=2)
        axes.plot([end], [place], "o", color=color, markersize=5)
    axes.axvline(1.0, color="black", linewidth=1)
    axes.set_yticks(range(len(margins)))
    axes.set_yticklabels([what for what, _, _ in margins])
    axes.set_xscale("log")
    axes.set_xlim(0.09, 1.4 * EDGE)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_title("times better than the goal", loc="left")
