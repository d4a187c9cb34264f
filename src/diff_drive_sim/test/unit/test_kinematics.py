"""The closed form of a robot's motion, against arithmetic with forty digits."""

import math
import random
from decimal import Decimal, getcontext
from typing import Tuple

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from diff_drive_sim.simulation.kinematics import (
    Pose,
    Wheels,
    body_speeds,
    chord,
    wheel_speeds,
    wrapped,
)
from diff_drive_sim.simulation.robot import Robot

getcontext().prec = 40
PI = Decimal("3.141592653589793238462643383279502884197169399")

COORDINATES = st.floats(-100.0, 100.0)
ANGLES = st.floats(-math.pi, math.pi)
POSES = st.builds(Pose, COORDINATES, COORDINATES, ANGLES)
DISTANCES = st.floats(-10.0, 10.0)
TURNS = st.floats(-20.0, 20.0) | st.floats(-1e-3, 1e-3)


def sine_and_cosine(angle: Decimal) -> Tuple[Decimal, Decimal]:
    """Return both to about 35 digits, by their series near 0."""
    angle = angle.remainder_near(2 * PI)
    sine, cosine, term, number = Decimal(0), Decimal(0), Decimal(1), 0
    while abs(term) > Decimal("1e-38"):
        if number % 2:
            sine += term if number % 4 == 1 else -term
        else:
            cosine += term if number % 4 == 0 else -term
        number += 1
        term = term * angle / number
    return sine, cosine


def exact(x: Decimal, y: Decimal, theta: Decimal, distance: Decimal, turn: Decimal) -> Tuple:
    """Return the end of an arc, by its circle: radius distance / turn."""
    before, after = sine_and_cosine(theta), sine_and_cosine(theta + turn)
    radius = distance / turn
    return x + radius * (after[0] - before[0]), y - radius * (after[1] - before[1]), theta + turn


def test_series_of_this_test_is_right() -> None:
    sine, cosine = sine_and_cosine(PI / 6)
    assert abs(sine - Decimal("0.5")) < Decimal("1e-35")
    assert abs(sine * sine + cosine * cosine - 1) < Decimal("1e-35")


@pytest.mark.parametrize("seed", range(3))
def test_after_1000_s_at_30_hz_it_is_within_a_nanometre(seed: int) -> None:
    chance = random.Random(seed)
    robot = Robot()
    at = (Decimal(0), Decimal(0), Decimal(0))
    dt = 1.0 / 30.0
    for _ in range(1000):
        linear, angular = chance.uniform(-0.15, 0.15), chance.uniform(-1.0, 1.0)
        robot.command(linear, angular)
        for _ in range(29):  # a command acts for 1 s, and the last step restarts that time
            robot.step(dt)
        robot.command(linear, angular)
        robot.step(dt)
        lasts = 30 * Decimal(dt)
        at = exact(*at, Decimal(linear) * lasts, Decimal(angular) * lasts)
    assert math.hypot(robot.pose.x - float(at[0]), robot.pose.y - float(at[1])) < 1e-9
    assert abs(wrapped(robot.pose.theta - float(at[2].remainder_near(2 * PI)))) < 1e-9


@pytest.mark.parametrize("linear, angular", [(0.2, 0.4), (0.22, 0.001), (0.22, 1e-9), (0.1, 2.0)])
def test_arc_of_1000_s_is_exact_for_any_division(linear: float, angular: float) -> None:
    end = exact(*map(Decimal, (0, 0, 0, linear)), Decimal(angular))  # of 1 s
    for _ in range(999):
        end = exact(*end, Decimal(linear), Decimal(angular))
    for pieces in (1, 1000, 30000):
        pose = Pose()
        for _ in range(pieces):
            pose = pose.moved(linear * 1000.0 / pieces, angular * 1000.0 / pieces)
        assert math.hypot(pose.x - float(end[0]), pose.y - float(end[1])) < 1e-9


@given(POSES, DISTANCES, TURNS)
def test_back_along_the_same_arc_leads_to_the_start(
    pose: Pose, distance: float, turn: float
) -> None:
    back = pose.moved(distance, turn).moved(-distance, -turn)
    assert back[:2] == pytest.approx(pose[:2], abs=1e-12)
    assert wrapped(back.theta - pose.theta) == pytest.approx(0.0, abs=1e-13)


@given(POSES, DISTANCES, TURNS, st.floats(0.0, 1.0))
def test_parts_of_arc_add_up(pose: Pose, distance: float, turn: float, part: float) -> None:
    whole = pose.moved(distance, turn)
    halves = pose.moved(part * distance, part * turn).moved(
        (1 - part) * distance, (1 - part) * turn
    )
    assert halves[:2] == pytest.approx(whole[:2], abs=1e-12)
    assert wrapped(halves.theta - whole.theta) == pytest.approx(0.0, abs=1e-13)


@given(POSES, DISTANCES, TURNS)
def test_heading_stays_within_half_a_turn(pose: Pose, distance: float, turn: float) -> None:
    theta = pose.moved(distance, turn).theta
    assert -math.pi <= theta <= math.pi
    assert math.sin(theta) == pytest.approx(math.sin(pose.theta + turn), abs=1e-14)
    assert math.cos(theta) == pytest.approx(math.cos(pose.theta + turn), abs=1e-14)


@given(POSES)
def test_zero_distance_keeps_pose(pose: Pose) -> None:
    assert pose.moved(0.0, 0.0) == pose


@pytest.mark.parametrize("half", [0.9999e-4, 1.0001e-4, 1e-9, 0.0])
def test_chord_is_exact_on_both_sides_of_its_series(half: float) -> None:
    true = sine_and_cosine(Decimal(half))[0] / Decimal(half) if half else Decimal(1)
    assert chord(1.0, 2.0 * half) == pytest.approx(float(true), abs=1.2e-16)


@given(
    st.floats(-1.0, 1.0), st.floats(-10.0, 10.0), st.floats(0.01, 100.0), st.floats(0.001, 100.0)
)
@example(0.0, 1.1125369292536007e-308, 0.01, 1.0)
def test_speeds_of_body_and_wheels_are_each_other_s_inverse(
    linear: float, angular: float, separation: float, radius: float
) -> None:
    wheels = wheel_speeds(linear, angular, separation, radius)
    back = body_speeds(wheels, separation, radius)
    # Rounding is that of the larger of what is added; numbers near 1e-308 have fewer digits.
    scale = abs(linear) + separation * abs(angular) + 1e-290
    assert back[0] == pytest.approx(linear, abs=4e-15 * scale)
    assert back[1] == pytest.approx(angular, abs=8e-15 * scale / separation)


def test_forward_and_left_are_as_rep_103_has_them() -> None:
    assert wheel_speeds(0.33, 0.0, 0.16, 0.033) == pytest.approx((10.0, 10.0))
    left, right = wheel_speeds(0.0, 1.0, 0.16, 0.033)
    assert left < 0.0 < right
    assert body_speeds(Wheels(1.0, 2.0), 0.16, 0.033)[1] > 0.0
    assert Pose().moved(math.pi / 2, math.pi / 2) == pytest.approx((1.0, 1.0, math.pi / 2))
