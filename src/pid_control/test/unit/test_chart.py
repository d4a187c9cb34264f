"""Tests of SVG charts."""

import math
import re
import xml.etree.ElementTree
from typing import List, Tuple

import pytest

from pid_control.charts.chart import Curve, Panel, _marks, as_svg, plot

SPACE = "{http://www.w3.org/2000/svg}"

#: Axes from the least value to the largest with a margin of 5 %, or with limits of their own.
PICTURE = """\
<svg xmlns="http://www.w3.org/2000/svg" width="712" height="236" font-family="sans-serif" \
font-size="11">
<rect width="712" height="236" fill="white"/>
<g transform="translate(56 36)">
<text y="-10">a &lt; b<tspan dx="12" fill="red">r &amp; y</tspan>\
<tspan dx="12" fill="green"></tspan></text>
<rect width="640" height="64" fill="none" stroke="#bbbbbb"/>
<path d="M0 61.1h640" stroke="#eeeeee"/>
<text x="-6" y="65.1" text-anchor="end">0</text>
<path d="M0 32.0h640" stroke="#eeeeee"/>
<text x="-6" y="36.0" text-anchor="end">5</text>
<path d="M0 2.9h640" stroke="#eeeeee"/>
<text x="-6" y="6.9" text-anchor="end">10</text>
<text x="0.0" y="80" text-anchor="middle">1 s</text>
<text x="160.0" y="80" text-anchor="middle">2 s</text>
<text x="320.0" y="80" text-anchor="middle">3 s</text>
<text x="480.0" y="80" text-anchor="middle">4 s</text>
<text x="640.0" y="80" text-anchor="middle">5 s</text>
<polyline points="0.0,61.1 160.0,2.9 320.0,32.0" fill="none" stroke="red"/>
<polyline points="0.0,49.5" fill="none" stroke="green"/>
</g>
<g transform="translate(56 170)">
<text y="-10">input<tspan dx="12" fill="blue">u</tspan></text>
<rect width="640" height="32" fill="none" stroke="#bbbbbb"/>
<path d="M0 32.0h640" stroke="#eeeeee"/>
<text x="-6" y="36.0" text-anchor="end">-1</text>
<path d="M0 16.0h640" stroke="#eeeeee"/>
<text x="-6" y="20.0" text-anchor="end">0</text>
<path d="M0 0.0h640" stroke="#eeeeee"/>
<text x="-6" y="4.0" text-anchor="end">1</text>
<text x="0.0" y="48" text-anchor="middle">1 s</text>
<text x="160.0" y="48" text-anchor="middle">2 s</text>
<text x="320.0" y="48" text-anchor="middle">3 s</text>
<text x="480.0" y="48" text-anchor="middle">4 s</text>
<text x="640.0" y="48" text-anchor="middle">5 s</text>
<polyline points="160.0,0.0 640.0,0.0 640.0,24.0" fill="none" stroke="blue"/>
</g>
</svg>
"""


def drawn(*curves: Curve) -> List[List[Tuple[float, float]]]:
    root = xml.etree.ElementTree.fromstring(as_svg([Panel("a < b", list(curves))]))
    return [
        [tuple(map(float, point.split(","))) for point in (line.get("points") or "").split()]
        for line in root.iter(SPACE + "polyline")
    ]


def test_picture_of_two_panels_is_complete() -> None:
    speed = Curve("r & y", "red", [1.0, 2.0, 3.0], [0.0, 10.0, 5.0])
    given = Curve("u", "blue", [2.0, 5.0], [1.0, -0.5], True)
    above = Panel("a < b", [speed, Curve("", "green", [1.0], [2.0])], 64.0)
    assert as_svg([above, Panel("input", [given], 32.0, (-1.0, 1.0))]) == PICTURE
    assert Panel("", [speed]).height == 160.0


@pytest.mark.parametrize(
    "low, high, count, marks",
    [
        (0.0, 6.0, 3, [0.0, 2.0, 4.0, 6.0]),
        (-4.9, 9.9, 3, [0.0, 5.0]),
        (0.0, 0.03, 3, [0.0, 0.01, 0.02, 0.03]),
        (1.0, 26.0, 4, [10.0, 20.0]),
        (0.0, 15.1, 5, [0.0, 5.0, 10.0, 15.0]),
    ],
)
def test_marks_are_round(low: float, high: float, count: int, marks: List[float]) -> None:
    assert _marks(low, high, count) == pytest.approx(marks)


@pytest.mark.parametrize("value, marks", [(math.nan, ["-1", "0", "1"]), (5.0, ["4", "5", "6"])])
def test_axis_of_a_constant_has_a_range(value: float, marks: List[str]) -> None:
    text = "\n".join(plot(Panel("", [Curve("", "red", [0.0], [value])], 40.0), 100.0, 0.0, 0.0))
    assert re.findall('text-anchor="end">(.*)<', text) == marks
    assert re.findall('"middle">(.*) s<', text) == ["0", "0.2", "0.4", "0.6", "0.8", "1"]
    assert "NaN" not in text and text.count('stroke="red"') == 1


def test_curve_goes_from_corner_to_corner_and_values_go_up() -> None:
    ((first, *_, last),) = drawn(Curve("&", "red", [0.0, 1.0, 2.0], [-1.0, 0.0, 1.0]))
    assert (first[0], last[0]) == (0.0, 640.0)
    assert first[1] > last[1] > 0.0


def test_value_that_holds_is_drawn_in_steps() -> None:
    (points,) = drawn(Curve("", "red", [0.0, 1.0], [0.0, 1.0], True))
    assert len(points) == 3
    assert points[1] == (points[2][0], points[0][1])


def zigzag(count: int) -> Curve:
    return Curve("", "red", list(range(count)), [(-1.0) ** number for number in range(count)])


def test_no_peak_is_lost_among_many_points() -> None:
    values = [0.0] * 100_000
    values[54_321] = 1.0
    (points,) = drawn(Curve("", "red", list(range(100_000)), values))
    assert len(points) < 1500
    assert len({y for _, y in points}) == 2
    # Two points per pixel column are all drawn.
    assert [len(one) for count in (1280, 1281) for one in drawn(zigzag(count))] == [1280, 641]


def test_many_points_are_drawn_in_the_order_of_time() -> None:
    values = [number * (-1.0) ** number for number in range(10_000)]
    (points,) = drawn(Curve("", "red", list(range(10_000)), values))
    assert len(points) < len(values) and points == sorted(points, key=lambda point: point[0])


def test_chart_draws_constant_and_not_finite_values() -> None:
    curves = drawn(
        Curve("", "red", [0.0, 1.0, 2.0], [math.inf, 5.0, 5.0]),
        Curve("", "red", [0.0], [5.0]),
    )
    assert [len(points) for points in curves] == [2, 1]


def test_axis_of_several_curves_has_room_for_all() -> None:
    small, large = (
        Curve("", "red", [0.0, 1.0], [0.0, 1.0]),
        Curve("", "red", [0.0, 1.0], [-5.0, 9.0]),
    )
    for curves in ((small, large), (large, small)):
        text = "\n".join(plot(Panel("", curves, 40.0), 100.0, 0.0, 1.0))
        parts = [part.split('"')[0].split() for part in text.split('points="')[1:]]
        heights = [float(point.split(",")[1]) for points in parts for point in points]
        assert 0.0 <= min(heights) < 5.0 and 35.0 < max(heights) <= 40.0


def test_axis_with_limits_of_its_own_shows_those() -> None:
    curve = Curve("", "red", [0.0, 1.0], [0.0, 0.5])
    text = "\n".join(plot(Panel("", [curve], 40.0, (-1.2, 1.2)), 100.0, 0.0, 2.0))
    assert 'points="0.0,20.0 50.0,11.7"' in text
    marks = [f'text-anchor="end">{mark}</text>' for mark in ("-1", "0", "1")]
    assert [mark in text for mark in marks] == [True, True, True]
    assert text.index('y="40.7" text-anchor="end">-1<') < text.index('y="7.3" text-anchor="end">1<')


def test_panels_share_the_time_axis_and_do_not_overlap() -> None:
    curves = [Curve("", "red", [5.0, 6.0], [0.0, 1.0]), Curve("", "red", [6.0, 7.0], [0.0, 1.0])]
    heights = (160.0, 40.0, 80.0)
    panels = [Panel("", [curve], height) for curve, height in zip([*curves, curves[0]], heights)]
    text = as_svg(panels)
    first, second, third = (part.split('"')[0].split() for part in text.split('points="')[1:])
    assert [one.split(",")[0] for one in (first[0], first[-1])] == ["0.0", "320.0"]
    assert [one.split(",")[0] for one in (second[0], second[-1])] == ["320.0", "640.0"]
    assert '<text x="320.0" y="176" text-anchor="middle">6 s</text>' in text
    places = [float(part.split(")")[0]) for part in text.split("translate(56 ")[1:]]
    assert [b - a - height for a, b, height in zip(places, places[1:], heights)] == [70.0, 70.0]
    # The title is above each plot, and the time below the last one.
    height = float(xml.etree.ElementTree.fromstring(text).get("height", "0"))
    assert 16.0 <= places[0] < 60.0 and 16.0 <= height - places[-1] - heights[-1] < 60.0
