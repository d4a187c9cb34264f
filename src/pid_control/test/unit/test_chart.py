"""Tests of SVG charts."""

import math
import xml.etree.ElementTree
from typing import List, Tuple

from pid_control.charts.chart import Curve, Panel, as_svg, plot

SPACE = "{http://www.w3.org/2000/svg}"


def drawn(*curves: Curve) -> List[List[Tuple[float, float]]]:
    root = xml.etree.ElementTree.fromstring(as_svg([Panel("a < b", list(curves))]))
    return [
        [tuple(map(float, point.split(","))) for point in (line.get("points") or "").split()]
        for line in root.iter(SPACE + "polyline")
    ]


def test_curve_goes_from_corner_to_corner_and_values_go_up() -> None:
    ((first, *_, last),) = drawn(Curve("&", "red", [0.0, 1.0, 2.0], [-1.0, 0.0, 1.0]))
    assert (first[0], last[0]) == (0.0, 640.0)
    assert first[1] > last[1] > 0.0


def test_value_that_holds_is_drawn_in_steps() -> None:
    (points,) = drawn(Curve("", "red", [0.0, 1.0], [0.0, 1.0], True))
    assert len(points) == 3
    assert points[1] == (points[2][0], points[0][1])


def test_no_peak_is_lost_among_many_points() -> None:
    values = [0.0] * 100_000
    values[54_321] = 1.0
    (points,) = drawn(Curve("", "red", list(range(100_000)), values))
    assert len(points) < 1500
    assert len({y for _, y in points}) == 2


def test_many_points_are_drawn_in_the_order_of_time() -> None:
    values = [number * (-1.0) ** number for number in range(10_000)]
    (points,) = drawn(Curve("", "red", list(range(10_000)), values))
    assert len(points) < len(values) and points == sorted(points, key=lambda point: point[0])


def test_chart_draws_constant_and_not_finite_values() -> None:
    curves = drawn(
        Curve("", "red", [0.0, 1.0, 2.0], [5.0, math.nan, 5.0]),
        Curve("", "red", [0.0], [5.0]),
    )
    assert [len(points) for points in curves] == [2, 1]


def test_axis_with_limits_of_its_own_shows_those() -> None:
    curve = Curve("", "red", [0.0, 1.0], [0.0, 0.5])
    text = "\n".join(plot(Panel("", [curve], 40.0, (-1.2, 1.2)), 100.0, 0.0, 2.0))
    assert 'points="0.0,20.0 50.0,11.7"' in text
    marks = [f'text-anchor="end">{mark}</text>' for mark in ("-1", "0", "1")]
    assert [mark in text for mark in marks] == [True, True, True]
