"""SVG chart of curves over time, in stacked panels.

Drawn here, as text: matplotlib with its dependencies weighs half as much as all others of this
workspace, so it is left to packages whose users ask for plots.
"""

import math
from html import escape
from typing import List, NamedTuple, Optional, Sequence, Tuple

#: Width of a panel's plot, and its margins.
_WIDTH, _LEFT, _RIGHT, _ABOVE, _BELOW = 640.0, 56.0, 16.0, 36.0, 34.0
#: Ticks of the time axis (approximate); height of a panel per tick of the value axis, and the
#: fewest ticks there.
_MARKS, _MARK_EVERY, _FEWEST_MARKS = 5, 32.0, 3


class Curve(NamedTuple):
    """A curve of a panel.

    :ivar name: text of the legend
    :ivar colour: SVG colour
    :ivar times: ascending [s]
    :ivar values: value at each time; values that are not finite are not drawn
    :ivar is_held: True to draw steps, each value held until the next one
    """

    name: str
    colour: str
    times: Sequence[float]
    values: Sequence[float]
    is_held: bool = False


class Panel(NamedTuple):
    """Curves on the same axes.

    :ivar title: title above the plot
    :ivar curves: at least one
    :ivar height: height of the plot
    :ivar limits: range of the value axis; None for the range of the curves
    """

    title: str
    curves: Sequence[Curve]
    height: float = 160.0
    limits: Optional[Tuple[float, float]] = None


def as_svg(panels: Sequence[Panel]) -> str:
    """Return an SVG file of panels that share the time axis.

    :param panels: from top to bottom; at least one
    """
    begin = min(min(curve.times) for panel in panels for curve in panel.curves)
    end = max(max(curve.times) for panel in panels for curve in panel.curves)
    whole = sum(panel.height + _ABOVE + _BELOW for panel in panels)
    size = f'width="{_LEFT + _WIDTH + _RIGHT:g}" height="{whole:g}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="11">',
        f'<rect {size} fill="white"/>',
    ]
    y = 0.0
    for panel in panels:
        parts.append(f'<g transform="translate({_LEFT:g} {y + _ABOVE:g})">')
        parts += plot(panel, _WIDTH, begin, end)
        parts.append("</g>")
        y += panel.height + _ABOVE + _BELOW
    return "\n".join([*parts, "</svg>"]) + "\n"


def plot(panel: Panel, width: float, begin: float, end: float) -> List[str]:
    """Return the SVG elements of a panel: the plot's upper left corner at (0, 0), the title above.

    :param panel: the panel
    :param width: width of the plot
    :param begin: time at the left edge [s]
    :param end: time at the right edge [s]
    """
    low, high = panel.limits or _needed(panel)
    span = end - begin or 1.0
    legend = "".join(
        f'<tspan dx="12" fill="{curve.colour}">{escape(curve.name)}</tspan>'
        for curve in panel.curves
    )
    parts = [
        f'<text y="-10">{escape(panel.title)}{legend}</text>',
        f'<rect width="{width:g}" height="{panel.height:g}" fill="none" stroke="#bbbbbb"/>',
    ]
    for mark in _marks(low, high, max(_FEWEST_MARKS, round(panel.height / _MARK_EVERY))):
        at = panel.height * (high - mark) / (high - low)
        parts.append(f'<path d="M0 {at:.1f}h{width:g}" stroke="#eeeeee"/>')
        parts.append(f'<text x="-6" y="{at + 4:.1f}" text-anchor="end">{mark:.6g}</text>')
    for mark in _marks(begin, begin + span, _MARKS):
        at = width * (mark - begin) / span
        below = f'y="{panel.height + 16:g}" text-anchor="middle"'
        parts.append(f'<text x="{at:.1f}" {below}>{mark:.6g} s</text>')
    for curve in panel.curves:
        points = [
            (width * (time - begin) / span, panel.height * (high - value) / (high - low))
            for time, value in _thinned(curve, 2.0 * width)  # two points per pixel column
        ]
        parts.append(_path(points, curve))
    return parts


def _needed(panel: Panel) -> Tuple[float, float]:
    values = [value for curve in panel.curves for value in curve.values if math.isfinite(value)]
    low, high = min(values, default=0.0), max(values, default=0.0)
    margin = 0.05 * (high - low) or 1.0
    return low - margin, high + margin


def _path(points: List[Tuple[float, float]], curve: Curve) -> str:
    places = []
    for index, (x, y) in enumerate(points):
        if index and curve.is_held:
            places.append(f"{x:.1f},{points[index - 1][1]:.1f}")
        places.append(f"{x:.1f},{y:.1f}")
    return f'<polyline points="{" ".join(places)}" fill="none" stroke="{curve.colour}"/>'


def _thinned(curve: Curve, most: float) -> List[Tuple[float, float]]:
    """Return the points to draw: all, or the extremes of each interval."""
    points = [
        (time, value) for time, value in zip(curve.times, curve.values) if math.isfinite(value)
    ]
    every = 2 * math.ceil(len(points) / most)
    if every <= 2:
        return points
    kept = []
    for start in range(0, len(points), every):
        stretch = points[start : start + every]
        ends = {min(stretch, key=lambda one: one[1]), max(stretch, key=lambda one: one[1])}
        kept += sorted(ends)
    return kept


def _marks(low: float, high: float, count: int) -> List[float]:
    """Return round tick values in a range; their number is approximate."""
    raw = (high - low) / count
    unit = 10.0 ** math.floor(math.log10(raw))
    step = next(unit * factor for factor in (1.0, 2.0, 5.0, 10.0) if unit * factor >= raw)
    first, last = math.ceil(low / step), math.floor(high / step)
    return [number * step for number in range(first, last + 1)]
