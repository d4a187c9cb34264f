"""Errors of the odometry: repeatable, bounded, and as large as its covariance says."""

import math
from typing import List

import numpy
import pytest

from diff_drive_sim.simulation.kinematics import Pose, wrapped
from diff_drive_sim.simulation.limits import RobotSettings
from diff_drive_sim.simulation.odometry import EXACT, wheel_paths
from diff_drive_sim.simulation.robot import Robot

K = 0.01
NOISY = RobotSettings(command_timeout=0.0, odometry_noise=K)


def driven(seed: int, seconds: float = 20.0, dt: float = 0.1) -> Robot:
    """Return a robot that has driven two curves."""
    robot = Robot(NOISY, seed=seed)
    for command in ((0.2, 0.3), (0.15, -0.5)):
        robot.command(*command)
        for _ in range(round(0.5 * seconds / dt)):
            robot.step(dt)
    return robot


def error(robot: Robot) -> List[float]:
    """Return the error of the odometry."""
    believed, true = robot.odometry.pose, robot.pose
    return [believed.x - true.x, believed.y - true.y, wrapped(believed.theta - true.theta)]


def covariance(robot: Robot) -> numpy.ndarray:
    xx, xy, xt, yy, yt, tt = robot.odometry.covariance
    return numpy.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])


@pytest.mark.parametrize("dt", [0.1, 10.0])
def test_errors_of_many_robots_are_spread_as_their_covariance_says(dt: float) -> None:
    count = 300
    robots = [driven(seed, dt=dt) for seed in range(count)]
    errors = numpy.array([error(robot) for robot in robots])
    said = covariance(robots[0])
    found = errors.T @ errors / count
    # A variance found of so many is off by 8 % in one of three, by 33 % in one of 25000 cases.
    assert numpy.diag(found) == pytest.approx(numpy.diag(said), rel=0.33)
    # Whatever the direction: the mean of e' C^-1 e is 3, and is off by 0.14 in one of three cases.
    assert numpy.mean(
        [e @ numpy.linalg.inv(covariance(robot)) @ e for e, robot in zip(errors, robots)]
    ) == pytest.approx(3.0, abs=0.6)
    # It drifts to neither side.
    assert numpy.abs(errors.mean(axis=0)).max() < 4.0 * math.sqrt(said.max() / count)


def test_covariance_is_that_of_a_straight_line_in_closed_form() -> None:
    # So small that the estimated heading stays that of the line.
    k, length, b = 1e-5, 10.0, NOISY.wheel_separation
    robot = Robot(NOISY._replace(odometry_noise=k), pose=Pose(0.0, 0.0, math.pi / 2))
    robot.command(0.2, 0.0)
    robot.step(50.0)
    xx, xy, xt, yy, yt, tt = robot.odometry.covariance
    # k^2 a metre for each wheel: half of it along the line; across it, the heading's adds up.
    assert yy == pytest.approx(0.5 * k**2 * length, rel=0.01)
    assert tt == pytest.approx(2.0 * k**2 * length / b**2, rel=1e-9)
    assert xx == pytest.approx(tt * length**2 / 3.0, rel=0.01)
    assert xt == pytest.approx(-tt * length / 2.0, rel=0.01)
    assert abs(xy) + abs(yt) < 0.01 * xx


def test_covariance_does_not_depend_on_the_steps() -> None:
    fine, coarse = (covariance(driven(0, dt=dt)) for dt in (0.02, 10.0))
    # The estimated path differs, and so do its directions.
    assert numpy.diag(coarse) == pytest.approx(numpy.diag(fine), rel=0.2)


def test_errors_are_determined_by_seed() -> None:
    assert driven(5).odometry.pose == driven(5).odometry.pose
    assert driven(5).odometry.pose != driven(6).odometry.pose
    robot = driven(5)
    first = error(robot)
    robot.reset(Pose(), seed=5)
    for command in ((0.2, 0.3), (0.15, -0.5)):
        robot.command(*command)
        for _ in range(100):
            robot.step(0.1)
    assert error(robot) == first


def test_error_of_a_step_is_bounded() -> None:
    robot = Robot(NOISY)
    robot.command(0.2, 0.5)
    true = wheel_paths(0.02, 0.05, NOISY.wheel_separation)
    for _ in range(2000):
        before = robot.odometry.angles
        robot.step(0.1)
        pieces = 2  # of at most 2 cm
        for wheel in (0, 1):
            path = (robot.odometry.angles[wheel] - before[wheel]) * NOISY.wheel_radius
            bound = math.sqrt(3.0) * K * math.sqrt(true[wheel] / pieces) * pieces
            assert abs(path - true[wheel]) <= bound * 1.000001


def test_pose_can_be_computed_from_the_wheels_angles() -> None:
    robot = Robot(NOISY)
    robot.command(0.2, 0.5)
    pose, before = Pose(), robot.odometry.angles
    for _ in range(200):
        robot.step(0.02)
        after = robot.odometry.angles
        left, right = (NOISY.wheel_radius * (b - a) for a, b in zip(before, after))
        pose, before = pose.moved((left + right) / 2, (right - left) / 0.160), after
    assert robot.odometry.pose == pytest.approx(pose, abs=1e-9)
    assert robot.odometry.pose != pytest.approx(robot.pose, abs=1e-6)


def test_without_noise_it_is_exact_and_says_so() -> None:
    robot = Robot()
    robot.command(0.2, 0.5)
    robot.step(1.0)
    assert robot.odometry.covariance == EXACT
    assert error(robot) == [0.0, 0.0, 0.0]
