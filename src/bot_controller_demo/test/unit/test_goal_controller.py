"""Goals, laws, limits, and how old odometry is."""

import math
from typing import Optional

import pytest
from geometry_msgs.msg import PoseStamped
from hypothesis import given
from hypothesis import strategies as st

from bot_controller_demo.driving.goals import GoalRefused, goal_of
from bot_controller_demo.control.staleness import Staleness
from bot_controller_demo.control.geometry import Errors, Goal, Pose, errors, heading_of, wrap
from bot_controller_demo.control.goal_controller import (
    ARRIVED,
    DRIVING,
    TURNING,
    GoalController,
    Tuning,
)
from bot_controller_demo.control.steering import LAWS, Gains, course, settling
from bot_controller_demo.control.velocities import STOP, Limits, Velocity, clamp, saturate
from bot_controller_demo.nodes.random_controller import Wanderer

TUNING = Tuning("settling", Gains(0.5, 1.0), Limits(0.5, 1.0), 0.1, 0.05)
ANGLES = st.floats(-math.pi, math.pi)
SPEEDS = st.floats(-1e3, 1e3)
LIMITS = st.builds(Limits, st.floats(1e-3, 10.0), st.floats(1e-3, 10.0))


@given(st.floats(-1e4, 1e4))
def test_an_angle_is_wrapped_to_the_same_direction(angle: float) -> None:
    assert abs(wrap(angle)) <= math.pi
    assert math.cos(wrap(angle)) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrap(angle)) == pytest.approx(math.sin(angle), abs=1e-9)


@given(ANGLES, st.sampled_from([1.0, -1.0, math.sqrt(2.0), 1e-3, 100.0]))
def test_heading_of_quaternion_of_any_norm(theta: float, length: float) -> None:
    z, w = length * math.sin(theta / 2.0), length * math.cos(theta / 2.0)
    assert wrap(heading_of(0.0, 0.0, z, w) - theta) == pytest.approx(0.0, abs=1e-9)


def test_heading_of_tilted_robot_is_its_forward_direction() -> None:
    half = 0.5 * 0.3  # pitched by 0.3 rad, then turned by 1 rad
    x, y, z, w = (
        -math.sin(half) * math.sin(0.5),
        math.sin(half) * math.cos(0.5),
        math.cos(half) * math.sin(0.5),
        math.cos(half) * math.cos(0.5),
    )
    assert heading_of(x, y, z, w) == pytest.approx(1.0)


def test_errors_are_seen_from_the_robot() -> None:
    seen = errors(Pose(1.0, 1.0, math.pi / 2.0), Goal(0.0, 1.0, math.pi))
    assert seen == pytest.approx((1.0, math.pi / 2.0, math.pi / 2.0))
    assert errors(Pose(0.0, 0.0, 1.0), Goal(3.0, 4.0)) == pytest.approx(
        (5.0, math.atan2(4.0, 3.0) - 1.0, 0.0)
    )


@given(SPEEDS, SPEEDS, LIMITS)
def test_saturation_keeps_limits_and_curvature(v: float, w: float, limits: Limits) -> None:
    kept = saturate(Velocity(v, w), limits)
    assert abs(kept.linear) <= limits.linear * (1.0 + 1e-12)
    assert abs(kept.angular) <= limits.angular * (1.0 + 1e-12)
    assert kept.linear * w == pytest.approx(kept.angular * v, rel=1e-9, abs=1e-300)
    if abs(v) <= limits.linear and abs(w) <= limits.angular:
        assert kept == (v, w)
    else:
        full = max(abs(kept.linear) / limits.linear, abs(kept.angular) / limits.angular)
        assert full == pytest.approx(1.0)


@given(SPEEDS, SPEEDS, LIMITS)
def test_clamping_cuts_each_part_by_itself(v: float, w: float, limits: Limits) -> None:
    linear, angular = clamp(Velocity(v, w), limits)
    assert linear == math.copysign(min(abs(v), limits.linear), v)
    assert angular == math.copysign(min(abs(w), limits.angular), w)


@given(st.floats(0.0, 10.0), ANGLES, ANGLES)
def test_the_settling_law_never_drives_away(distance: float, a: float, heading: float) -> None:
    velocity = settling(Errors(distance, a, heading), Gains(0.5, 1.0))
    assert velocity.linear * math.cos(a) >= 0.0 and velocity.linear >= 0.0
    assert velocity.angular == a


def test_laws_on_a_straight_line_are_the_course_s_formula() -> None:
    for law in LAWS.values():
        assert law(Errors(5.0, 0.0, 0.0), Gains(0.5, 1.0)) == Velocity(2.5, 0.0)


def test_the_law_of_the_course_blends_into_the_last_heading() -> None:
    gains = Gains(0.5, 2.0)
    assert course(Errors(0.5, 0.3, -1.0), gains) == pytest.approx((0.25, 0.6))
    assert course(Errors(0.25, 0.3, -1.0), gains) == pytest.approx((0.125, -0.7))


def at(controller: GoalController, x: float, theta: float) -> str:
    """Return the phase of a controller with the robot on the x axis."""
    return controller.step(Pose(x, 0.0, theta), TUNING).phase


def test_arrival_has_hysteresis() -> None:
    controller = GoalController(Goal(0.0, 0.0, 0.0))
    assert at(controller, -0.101, 0.0) == DRIVING
    assert at(controller, -0.1, 0.3) == TURNING
    assert at(controller, -0.19, 0.06) == TURNING
    assert at(controller, -0.19, 0.05) == ARRIVED
    assert at(controller, -0.2, 0.1) == ARRIVED
    assert at(controller, -0.2, 0.101) == TURNING
    assert at(controller, -0.201, 0.0) == DRIVING
    assert at(controller, -0.15, 0.0) == DRIVING


def test_arrived_robot_stops_and_goal_without_heading_needs_no_turn() -> None:
    step = GoalController(Goal(0.05, 0.0)).step(Pose(0.0, 0.0, 2.0), TUNING)
    assert (step.velocity, step.phase) == (STOP, ARRIVED)


def test_turn_takes_shorter_direction_and_restarts_with_new_goal() -> None:
    controller = GoalController(Goal(0.0, 0.0, 0.0))
    assert controller.step(Pose(0.0, 0.0, 3.0), TUNING).velocity.angular == -1.0
    assert controller.step(Pose(0.0, 0.0, -3.0), TUNING).velocity.angular == -1.0
    # Once it has come below 3/4 pi on the other side, that side is the short one.
    assert controller.step(Pose(0.0, 0.0, -2.0), TUNING).velocity.angular == 1.0
    assert controller.step(Pose(0.0, 0.0, -3.0), TUNING).velocity.angular == 1.0
    assert (
        GoalController(Goal(0.0, 0.0, 0.0)).step(Pose(0.0, 0.0, 3.0), TUNING).velocity.angular
        == -1.0
    )


def test_age_is_that_of_the_stamp_or_of_the_arrival() -> None:
    staleness = Staleness()
    assert staleness.age(10.0) == math.inf
    staleness.record_message(9.9, 10.0)
    assert staleness.age(10.0) == pytest.approx(0.1)
    staleness.record_message(99.0, 10.0)  # by a clock that is ahead
    assert staleness.age(13.0) == 3.0
    staleness.record_message(0.0, 20.0)  # without a stamp
    assert staleness.age(20.5) == 0.5
    assert staleness.age(19.0) == math.inf  # the clock was set back
    staleness.record_message(5.0, 20.0)  # late, out of a cut link
    assert staleness.age(20.0) == 15.0


def pose(frame: str = "", x: float = 0.0, z: float = 0.0, w: float = 1.0) -> PoseStamped:
    """Return a goal as a message."""
    message = PoseStamped()
    message.header.frame_id, message.pose.position.x = frame, x
    message.pose.orientation.z, message.pose.orientation.w = z, w
    return message


@pytest.mark.parametrize(
    "named, frame", [("odom", "odom"), ("/odom", "odom"), ("odom", "/odom"), ("", None)]
)
def test_goal_frame_must_be_odometry_frame_or_empty(named: str, frame: Optional[str]) -> None:
    assert goal_of(pose(named, 2.0), frame) == Goal(2.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "message, frame, reason",
    [
        (pose("map"), "odom", "frame_id 'map': must be 'odom', that of the odometry, or empty"),
        (pose("odom"), None, "frame_id 'odom': must be empty while there is no odometry"),
        (pose(w=0.0), "odom", "must be a quaternion"),
        (pose(x=math.nan), "odom", "each must be in \\[-1e6, 1e6]"),
        (pose(z=math.inf), "odom", "each must be in \\[-1e6, 1e6]"),
        (pose(x=1.1e6), "odom", "x 1.1e\\+06 m, .*: each must be in \\[-1e6, 1e6]"),
        (pose(x=-1e308), "odom", "each must be in \\[-1e6, 1e6]"),
    ],
)
def test_invalid_goal_is_rejected_with_message(
    message: PoseStamped, frame: Optional[str], reason: str
) -> None:
    with pytest.raises(GoalRefused, match=reason):
        goal_of(message, frame)


def test_the_same_seed_gives_the_same_velocities_within_the_limits() -> None:
    one, same, other, any_one = (Wanderer(seed) for seed in (7, 7, 8, 0))
    drawn = [wanderer.draw((0.1, 0.2), (-1.0, 1.0)) for wanderer in (one, same, other, any_one)]
    assert drawn[0] == drawn[1] and len(set(drawn)) == 3
    assert one.draw((0.1, 0.2), (-1.0, 1.0)) != drawn[0]
    for _ in range(100):
        linear, angular = one.draw((0.1, 0.2), (-1.0, 1.0))
        assert 0.1 <= linear <= 0.2 and -1.0 <= angular <= 1.0
    assert one.draw((0.3, 0.3), (0.0, 0.0)) == (0.3, 0.0)
