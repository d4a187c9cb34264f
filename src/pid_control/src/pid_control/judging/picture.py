"""All scenarios in one picture: what was asked for, what the motor did, and its input. SVG."""

import math
from html import escape
from typing import Callable, List, Sequence

from pid_control.judging.record import Record, Row

#: Columns of panels; size of a panel's plots, of the room about them, and of the heading.
_COLUMNS = 3
_WIDTH, _SPEED_HEIGHT, _INPUT_HEIGHT = 260.0, 90.0, 40.0
_LEFT, _RIGHT, _ABOVE, _GAP, _BELOW = 34.0, 16.0, 22.0, 8.0, 22.0
_HEADING = 34.0
#: Colours that are told apart by those who see few.
_SET_POINT, _SPEED, _INPUT, _WRONG = "#888888", "#0072b2", "#d55e00", "#b00020"
#: The input's axis goes beyond its limits by this.
_BEYOND = 1.2


def as_svg(records: Sequence[Record], title: str, failed: Sequence[str]) -> str:
    """Return the picture.

    :param records: what came of the scenarios
    :param title: what stands above
    :param failed: names of the scenarios in which something was wrong
    """
    tall = _ABOVE + _SPEED_HEIGHT + _GAP + _INPUT_HEIGHT + _BELOW
    wide = _LEFT + _WIDTH + _RIGHT
    lines = math.ceil(len(records) / _COLUMNS)
    size = f"{_COLUMNS * wide:.0f}", f"{_HEADING + lines * tall:.0f}"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]}"'
        f' viewBox="0 0 {size[0]} {size[1]}" font-family="sans-serif" font-size="10">',
        f'<rect width="{size[0]}" height="{size[1]}" fill="white"/>',
        f'<text x="{_LEFT}" y="16" font-size="13">{escape(title)}</text>',
        f'<text x="{_LEFT}" y="30"><tspan fill="{_SET_POINT}">set point, rad/s</tspan>'
        f'  <tspan fill="{_SPEED}">motor, rad/s</tspan>'
        f'  <tspan fill="{_INPUT}">input</tspan></text>',
    ]
    for index, record in enumerate(records):
        x, y = index % _COLUMNS * wide + _LEFT, index // _COLUMNS * tall + _HEADING
        parts.append(f'<g transform="translate({x:.0f} {y:.0f})">')
        parts += _panel(record, record.scenario.name in failed)
        parts.append("</g>")
    return "\n".join([*parts, "</svg>"]) + "\n"


def _panel(record: Record, is_wrong: bool) -> List[str]:
    colour = _WRONG if is_wrong else "black"
    heading = f"{record.scenario.name}: {record.scenario.about}"
    parts = [f'<text y="{_ABOVE - 6}" fill="{colour}">{escape(heading)}</text>']
    rows = _thinned(record.rows)
    if not rows:
        return [*parts, f'<text y="{_ABOVE + 20}" fill="{_WRONG}">{escape(record.fate)}</text>']
    speeds = [value for row in rows for value in (row.speed, row.set_point)] + [0.0]
    low, high = min(speeds), max(speeds)
    margin = 0.05 * (high - low) or 1.0
    top = _ABOVE + _SPEED_HEIGHT + _GAP
    duration = record.scenario.duration
    parts += _axes(_ABOVE, _SPEED_HEIGHT, low - margin, high + margin, (low, high))
    parts += _axes(top, _INPUT_HEIGHT, -_BEYOND, _BEYOND, (-1.0, 1.0))
    upper = _curve(rows, duration, _ABOVE, _SPEED_HEIGHT, low - margin, high + margin)
    lower = _curve(rows, duration, top, _INPUT_HEIGHT, -_BEYOND, _BEYOND)
    parts.append(upper(lambda row: row.set_point, _SET_POINT))
    parts.append(upper(lambda row: row.speed, _SPEED))
    parts.append(lower(lambda row: max(-_BEYOND, min(_BEYOND, row.input)), _INPUT))
    end = top + _INPUT_HEIGHT + 12
    parts.append(f'<text y="{end}">0</text>')
    parts.append(f'<text x="{_WIDTH}" y="{end}" text-anchor="end">{duration:g} s</text>')
    return parts


def _axes(top: float, height: float, low: float, high: float, marked: Sequence[float]) -> List[str]:
    parts = [f'<rect y="{top}" width="{_WIDTH}" height="{height}" fill="none" stroke="#cccccc"/>']
    for value in marked:
        y = top + height * (high - value) / (high - low)
        parts.append(f'<path d="M0 {y:.1f}h{_WIDTH}" stroke="#eeeeee"/>')
        parts.append(f'<text x="-4" y="{y + 3:.1f}" text-anchor="end">{value:.3g}</text>')
    return parts


def _curve(
    rows: Sequence[Row], duration: float, top: float, height: float, low: float, high: float
) -> Callable[[Callable[[Row], float], str], str]:
    """Return what draws one value of the rows in one colour."""

    def draw(value: Callable[[Row], float], colour: str) -> str:
        points = " ".join(
            f"{_WIDTH * row.time / duration:.1f},"
            f"{top + height * (high - value(row)) / (high - low):.1f}"
            for row in rows
        )
        return f'<polyline points="{points}" fill="none" stroke="{colour}"/>'

    return draw


def _thinned(rows: Sequence[Row]) -> List[Row]:
    """Leave out rows that nobody sees, but none in which something leaps."""
    most = 2.0 * _WIDTH
    every = max(1, math.ceil(len(rows) / most))
    kept = []
    for index, row in enumerate(rows):
        before = rows[index - 1] if index else row
        leaps = row.set_point != before.set_point or abs(row.input - before.input) > 0.05
        if index % every == 0 or leaps or row is rows[-1]:
            kept.append(row)
    return kept
