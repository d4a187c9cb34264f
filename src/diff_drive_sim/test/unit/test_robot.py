"""State of the simulated robot: limits, time, and walls."""

import math
from typing import List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from diff_drive_sim.simulation.kinematics import Pose, Wheels, wheel_speeds, wrapped
from diff_drive_sim.simulation.limits import RobotSettings, saturated
from diff_drive_sim.simulation.robot import LONGEST_STEP_S, Robot
from diff_drive_sim.simulation.world import World

BURGER = RobotSettings()
WAFFLE = RobotSettings(0.287, 0.033, 0.220, 0.26, 1.82, 8.06)
HOUR = 3600.0
#: Rounding of a limit, as a factor.
ROUNDING = 1.0 + 1e-12

FINITE = st.floats(allow_nan=False, allow_infinity=False)
COMMANDS = st.tuples(FINITE | st.floats(-1.0, 1.0), FINITE | st.floats(-5.0, 5.0))
STEPS = st.sampled_from([0.0, 1e-9, 0.001, 1.0 / 30.0, 0.3, 2.0]) | st.floats(0.0, 10.0)
ROBOTS = st.sampled_from([BURGER, WAFFLE])


def forever(settings: RobotSettings = BURGER, **changes: float) -> RobotSettings:
    return settings._replace(command_timeout=0.0, **changes)


def wheels_of(linear: float, angular: float, robot: RobotSettings) -> Wheels:
    return wheel_speeds(linear, angular, robot.wheel_separation, robot.wheel_radius)


@given(COMMANDS, ROBOTS)
def test_limits_are_met_and_never_exceeded(
    command: Tuple[float, float], robot: RobotSettings
) -> None:
    linear, angular = saturated(*command, robot)
    wheels = wheels_of(linear, angular, robot)
    used = [
        abs(linear) / robot.max_linear_velocity,
        abs(angular) / robot.max_angular_velocity,
        max(map(abs, wheels)) / robot.max_wheel_speed,
    ]
    assert max(used) <= ROUNDING
    if (linear, angular) != command:
        assert max(used) == pytest.approx(1.0)


@given(st.floats(-10.0, 10.0), st.floats(-100.0, 100.0), ROBOTS)
def test_curve_is_kept(linear: float, angular: float, robot: RobotSettings) -> None:
    slow, turn = saturated(linear, angular, robot)
    assert slow * angular == pytest.approx(turn * linear, rel=1e-12, abs=1e-300)
    assert slow * linear >= 0.0 and turn * angular >= 0.0


@given(
    st.lists(st.tuples(COMMANDS, STEPS | st.just(HOUR)), max_size=8),
    ROBOTS | ROBOTS.map(forever),
    st.sampled_from([0.0, 0.5, 5.0, 1000.0]),
)
def test_neither_speed_nor_its_change_exceeds_a_limit_in_any_run(
    run: List[Tuple[Tuple[float, float], float]], settings: RobotSettings, acceleration: float
) -> None:
    robot = Robot(settings._replace(max_wheel_acceleration=acceleration))
    for command, dt in run:
        robot.command(*command)
        before, start = robot.wheels, robot.pose
        robot.step(dt)
        assert max(map(abs, robot.wheels)) <= settings.max_wheel_speed * ROUNDING
        if acceleration:
            change = max(abs(b - a) for a, b in zip(before, robot.wheels))
            assert change <= acceleration * dt * ROUNDING + 1e-12
        way = math.hypot(robot.pose.x - start.x, robot.pose.y - start.y)
        assert way <= settings.max_linear_velocity * dt * ROUNDING + 1e-12
        assert all(map(math.isfinite, robot.pose))


def test_speeds_jump_without_a_limit_of_acceleration() -> None:
    robot = Robot()
    robot.command(0.1, 0.5)
    robot.step(1e-6)
    assert robot.speeds == pytest.approx((0.1, 0.5))


@pytest.mark.parametrize("pieces", [1, 7, 1000])
def test_speed_ramps_up_and_down_as_the_wheels_can(pieces: int) -> None:
    # 2 rad/s^2 take the wheels to 0.2 m/s in 3.03 s, and as long back.
    robot = Robot(forever(max_wheel_acceleration=2.0))
    rise = 0.2 / 0.033 / 2.0
    for command, end in ((0.2, 0.2 * rise / 2.0 + 0.2 * (10.0 - rise)), (0.0, 2.0)):
        robot.command(command, 0.0)
        for _ in range(pieces):
            robot.step(10.0 / pieces)
        assert robot.pose.x == pytest.approx(end, abs=1e-9)
        assert robot.speeds[0] == pytest.approx(command, abs=1e-12)
    assert robot.pose[1:] == (0.0, 0.0)


def test_ramp_of_a_curve_is_near_that_of_fine_steps() -> None:
    ends = []
    for pieces in (1, 20000):
        robot = Robot(forever(max_wheel_acceleration=2.0))
        robot.command(0.1, 1.0)
        for _ in range(pieces):
            robot.step(4.0 / pieces)
        ends.append(robot.pose)
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


@given(COMMANDS, st.integers(1, 50), st.sampled_from([0.0, 3.0]))
def test_steps_add_up_to_one_step(
    command: Tuple[float, float], pieces: int, acceleration: float
) -> None:
    once, often = (Robot(BURGER._replace(max_wheel_acceleration=acceleration)) for _ in range(2))
    for robot in (once, often):
        robot.command(*command)
    once.step(2.0)  # beyond the time-out
    for _ in range(pieces):
        often.step(2.0 / pieces)
    # A ramp is cut into other pieces, and is then not quite the same curve.
    tolerance = 1e-5 if acceleration else 1e-12
    assert often.pose[:2] == pytest.approx(once.pose[:2], abs=tolerance)
    assert wrapped(often.pose.theta - once.pose.theta) == pytest.approx(0.0, abs=1e-12)
    assert often.wheels == pytest.approx(once.wheels, abs=1e-9)


@pytest.mark.parametrize("dt", [0.0, -1.0, -HOUR])
def test_robot_does_not_move_without_time_advance(dt: float) -> None:
    robot = Robot()
    robot.command(0.1, 1.0)
    robot.step(0.5)
    pose, wheels, odometry = robot.pose, robot.wheels, robot.odometry.pose
    robot.step(dt)
    assert (robot.pose, robot.wheels, robot.odometry.pose) == (pose, wheels, odometry)
    robot.step(HOUR)  # half of the command's second is left
    assert robot.pose == pytest.approx(Pose().moved(0.1, 1.0), abs=1e-12)


def test_long_step_ends_with_command_timeout() -> None:
    robot = Robot()
    robot.command(0.2, 0.0)
    robot.step(HOUR)
    assert robot.pose == pytest.approx((0.2, 0.0, 0.0))
    assert robot.speeds == (0.0, 0.0)


def test_an_hour_without_a_time_out_is_driven_exactly() -> None:
    robot = Robot(forever())
    robot.command(0.1, 2.0)
    robot.step(HOUR)
    assert robot.pose == pytest.approx(
        (0.05 * math.sin(7200.0), 0.05 * (1.0 - math.cos(7200.0)), wrapped(7200.0)), abs=1e-9
    )


def test_clock_that_jumps_by_years_is_taken_for_an_hour() -> None:
    # Simulating all of it would take 5e10 pieces of a path, which is days.
    robot, other = Robot(forever(odometry_noise=0.01)), Robot(forever(odometry_noise=0.01))
    for each, seconds in ((robot, 2e9), (other, LONGEST_STEP_S)):
        each.command(0.22, 2.84)
        each.step(seconds)
    assert robot.odometry.pose == other.odometry.pose


def test_each_command_restarts_timeout() -> None:
    robot = Robot(BURGER._replace(command_timeout=0.5))
    for _ in range(4):
        robot.command(0.1, 0.0)
        robot.step(0.4)
    assert robot.pose.x == pytest.approx(0.16)
    robot.step(0.4)
    assert robot.pose.x == pytest.approx(0.17)
    assert robot.speeds == (0.0, 0.0)


def test_a_new_time_out_ends_the_command_in_force_too() -> None:
    robot = Robot(forever())
    robot.command(0.1, 0.0)
    robot.step(HOUR)
    robot.change(BURGER._replace(command_timeout=0.5))
    robot.step(0.4)
    robot.change(BURGER._replace(command_timeout=0.5, odometry_noise=0.01))
    robot.step(HOUR)  # a tenth of a second is left: nothing else prolongs it
    assert robot.pose.x == pytest.approx(360.05)
    assert robot.speeds == (0.0, 0.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_non_finite_command_is_rejected_without_effect(value: float) -> None:
    robot = Robot()
    robot.command(0.1, 0.0)
    for command in ((value, 0.0), (0.0, value)):
        with pytest.raises(ValueError, match="must be finite"):
            robot.command(*command)
    robot.step(1.0)
    assert robot.pose == pytest.approx((0.1, 0.0, 0.0))


def test_reset_puts_it_to_a_place_at_rest_and_without_a_command() -> None:
    robot = Robot(forever())
    robot.command(0.1, 1.0)
    robot.step(3.0)
    robot.reset(Pose(1.0, 2.0, 3.0))
    robot.step(1.0)
    assert robot.pose == robot.odometry.pose == Pose(1.0, 2.0, 3.0)
    assert robot.speeds == (0.0, 0.0)
    assert robot.odometry.angles == (0.0, 0.0)


def test_odometry_without_noise_is_the_truth_to_the_last_bit() -> None:
    robot = Robot(forever(), World([(0.5, -1.0, 0.5, 1.0)]), Pose(-1.0, 0.0, 0.1))
    for step in range(500):
        robot.command(0.3 * math.sin(step), math.cos(0.1 * step))
        robot.step(0.05)
        assert robot.odometry.pose == robot.pose


@pytest.mark.parametrize("steps", [1, 7, 1000])
def test_robot_stops_on_contact_with_wall(steps: int) -> None:
    robot = Robot(forever(), World([(1.0, -1.0, 1.0, 1.0)]))
    robot.command(0.2, 0.0)
    for _ in range(steps):
        robot.step(HOUR / steps)
    assert robot.touches
    assert robot.pose.x == pytest.approx(1.0 - BURGER.robot_radius, abs=1e-6)
    assert robot.pose.x <= 1.0 - BURGER.robot_radius
    assert robot.speeds == (0.0, 0.0)
    # Its wheels have not turned further.
    assert robot.odometry.angles.left * 0.033 == pytest.approx(robot.pose.x)


def test_it_turns_at_a_wall_and_drives_away() -> None:
    robot = Robot(forever(), World([(1.0, -1.0, 1.0, 1.0)]))
    robot.command(0.2, 0.0)
    robot.step(10.0)
    assert robot.touches
    robot.command(0.0, 1.0)
    robot.step(math.pi)
    assert not robot.touches
    assert wrapped(robot.pose.theta - math.pi) == pytest.approx(0.0, abs=1e-9)
    robot.command(0.2, 0.0)
    robot.step(1.0)
    assert not robot.touches
    assert robot.pose.x == pytest.approx(1.0 - BURGER.robot_radius - 0.2, abs=1e-6)


@pytest.mark.parametrize("steps", [1, 3, 300])
@pytest.mark.parametrize("acceleration", [0.0, 20.0])
def test_a_wall_takes_the_speed_forward_and_not_the_turn(steps: int, acceleration: float) -> None:
    settings = forever(max_wheel_acceleration=acceleration)
    robot = Robot(settings, World([(1.0, -9.0, 1.0, 9.0)]))
    robot.command(0.2, 0.0)
    robot.step(10.0)
    x = robot.pose.x
    robot.command(0.2, 0.5)
    for _ in range(steps):
        robot.step(1.0 / steps)
    assert robot.touches
    # Wheels with a limit get to the rate of the turn later.
    assert robot.pose.theta == pytest.approx(0.4 if acceleration else 0.5, abs=0.07)
    assert robot.pose.x == pytest.approx(x, abs=1e-6)
    assert robot.speeds == pytest.approx((0.0, 0.5), rel=0.1, abs=1e-9)
    # Along the wall and away from it the way is free again.
    for _ in range(30 * steps):
        robot.step(0.15 / steps)
    assert not robot.touches
    assert robot.pose.x < x - 0.1
    assert robot.speeds == pytest.approx((0.2, 0.5))


def test_robot_placed_in_wall_can_leave_it() -> None:
    robot = Robot(forever(), World([(0.05, -1.0, 0.05, 1.0)]))
    robot.command(0.2, 0.0)
    robot.step(1.0)
    assert robot.pose.x == pytest.approx(0.0, abs=1e-6)
    robot.command(-0.2, 0.0)
    robot.step(1.0)
    assert robot.pose.x == pytest.approx(-0.2)


ROOM = World(
    [(-1, -1, 1, -1), (1, -1, 1, 1), (1, 1, -1, 1), (-1, 1, -1, -1), (0.3, 0.6, 0.9, 0.2)],
    [(-0.5, -0.5, 0.3, 0.2, 0.7)],
)


@given(
    st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-3.0, 3.0), STEPS), max_size=10),
    st.sampled_from([0.0, 10.0]),
)
def test_robot_never_enters_wall(
    run: List[Tuple[float, float, float]], acceleration: float
) -> None:
    robot = Robot(forever(max_wheel_acceleration=acceleration), ROOM)
    for linear, angular, dt in run:
        robot.command(linear, angular)
        robot.step(dt)
        # Past a corner, pieces of a tenth of the radius may come 0.13 mm too near.
        assert ROOM.distance(robot.pose.x, robot.pose.y) > BURGER.robot_radius - 2e-4
        assert max(abs(robot.pose.x), abs(robot.pose.y)) < 1.0
