"""Room of the lidar, measured along lines of known length."""

import math

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parameters_demo.room import (
    MODELS,
    PERSON_RADIUS,
    ROUND_S,
    Scanner,
    distances,
    person,
    scan,
)

#: Time at which the person is at the left, out of the way of these measurements.
LEFT = 0.25 * ROUND_S


def measured(angle: float, time: float = LEFT) -> float:
    return float(distances(numpy.array([angle]), time)[0])


@pytest.mark.parametrize(
    "angle, expected",
    [
        (math.pi, 4.0),  # the wall behind
        (-math.pi / 2, 3.0),  # the one to the right
        (math.atan2(-2.9, 6.0), math.hypot(6.0, 2.9)),  # the one ahead, beside the door
        (0.0, math.inf),  # through the door
        (math.atan2(0.69, 6.0), math.inf),
        (math.atan2(0.71, 6.0), math.hypot(6.0, 0.71)),
        (math.atan2(-1.75, -1.5), math.hypot(1.75, 1.5)),  # the cabinet
        (math.atan2(1.5, 2.5), math.hypot(1.5, 2.5) - 0.2),  # the pillar
    ],
)
def test_distances_match_room(angle: float, expected: float) -> None:
    assert measured(angle) == pytest.approx(expected, abs=1e-12)


@given(st.floats(0.0, 1e9))
def test_the_person_is_nearer_than_the_walls_and_walks_around(time: float) -> None:
    x, y = person(time)
    assert (x / 2.0) ** 2 + (y / 1.2) ** 2 == pytest.approx(1.0)
    found = measured(math.atan2(y, x), time)
    assert found == pytest.approx(math.hypot(x, y) - PERSON_RADIUS, abs=1e-9)


def test_person_hides_only_objects_behind() -> None:
    angles = numpy.linspace(-math.pi, math.pi, 721)
    here, there = distances(angles, 0.0), distances(angles, 0.5 * ROUND_S)
    nearer = numpy.degrees(angles[here < there])
    half = math.degrees(math.asin(PERSON_RADIUS / 2.0))
    assert nearer.min() == pytest.approx(-half, abs=0.5)
    assert nearer.max() == pytest.approx(half, abs=0.5)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 100.0))
def test_a_turn_later_all_is_the_same(angle: float, time: float) -> None:
    assert measured(angle, time) == pytest.approx(measured(angle + math.tau, time), abs=1e-6)


def test_too_near_and_too_far_are_distinguished() -> None:
    found = scan(Scanner(-math.pi / 2, math.pi, 4, 3.5, 5.0), LEFT)
    assert list(found) == [-math.inf, math.inf, -math.inf, 4.0]


@pytest.mark.parametrize("model", MODELS)
def test_a_model_has_a_ray_at_each_end(model: str) -> None:
    scanner = MODELS[model]
    found = scan(scanner, 1.0)
    last = scanner.angle_min + (len(found) - 1) * scanner.angle_increment
    assert last == pytest.approx(scanner.angle_max, abs=1e-12)
    inside = found[numpy.isfinite(found)]
    assert scanner.range_min <= inside.min() and inside.max() <= scanner.range_max
    assert len(inside) > len(found) / 3
