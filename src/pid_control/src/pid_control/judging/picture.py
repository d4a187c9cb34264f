"""SVG picture of all scenarios: set point, speed and input of the motor."""

import math
from html import escape
from typing import List, Sequence

from pid_control.charts.chart import Curve, Panel, plot
from pid_control.judging.record import Record

#: Columns of panels; size of a panel's plots, their margins, and height of the heading.
_COLUMNS = 3
_WIDTH, _SPEED_HEIGHT, _INPUT_HEIGHT = 260.0, 90.0, 40.0
_LEFT, _RIGHT, _ABOVE, _GAP, _BELOW = 34.0, 32.0, 22.0, 24.0, 22.0
_HEADING = 34.0
#: Colours that colour-blind readers can distinguish.
_SET_POINT, _SPEED, _INPUT, _WRONG = "#888888", "#0072b2", "#d55e00", "#b00020"
#: Least end of the input's axis; the motor's limit is 1.
_BEYOND = 1.2


def as_svg(records: Sequence[Record], title: str, failed: Sequence[str]) -> str:
    """Return the SVG picture.

    :param records: records of the scenarios
    :param title: title of the picture
    :param failed: names of the failed scenarios
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
    if not record.rows:
        return [*parts, f'<text y="{_ABOVE + 20}" fill="{_WRONG}">{escape(record.failure)}</text>']
    times = [row.time for row in record.rows]
    speeds = [
        Curve("", _SET_POINT, times, [row.set_point for row in record.rows]),
        Curve("", _SPEED, times, [row.speed for row in record.rows]),
    ]
    inputs = [row.input for row in record.rows]
    largest = max(abs(value) for value in inputs)
    end = max(1.1 * largest, _BEYOND)
    if record.scenario.held_speed is not None and largest > 0.0:
        end = 1.1 * largest  # the answers to small errors decide
    upper = Panel("", speeds, _SPEED_HEIGHT)
    lower = Panel("", [Curve("", _INPUT, times, inputs)], _INPUT_HEIGHT, (-end, end))
    for panel, top in ((upper, _ABOVE), (lower, _ABOVE + _SPEED_HEIGHT + _GAP)):
        parts.append(f'<g transform="translate(0 {top:.0f})">')
        parts += plot(panel, _WIDTH, 0.0, record.scenario.duration)
        parts.append("</g>")
    return parts
