"""Limits of a robot's wheels: speed and acceleration."""

from typing import NamedTuple, Tuple

from diff_drive_sim.simulation.kinematics import Wheels, wheel_speeds

#: Faster than any robot, in m/s and in rad/s.
_HUGE = 1e6


class RobotSettings(NamedTuple):
    """Geometry and limits of a robot; the defaults are a TurtleBot3 Burger's.

    :ivar wheel_separation: distance of the wheels, m, > 0
    :ivar wheel_radius: m, > 0
    :ivar robot_radius: of the circle around the robot that walls do not enter, m, >= 0
    :ivar max_linear_velocity: m/s, > 0
    :ivar max_angular_velocity: rad/s, > 0
    :ivar max_wheel_speed: rad/s, > 0
    :ivar max_wheel_acceleration: rad/s^2; 0 for none: speeds jump
    :ivar command_timeout: how long a command acts, s; 0 for ever
    :ivar odometry_noise: standard deviation of what a wheel's measured path is off after 1 m, m
    """

    wheel_separation: float = 0.160
    wheel_radius: float = 0.033
    robot_radius: float = 0.105
    max_linear_velocity: float = 0.22
    max_angular_velocity: float = 2.84
    max_wheel_speed: float = 8.06
    max_wheel_acceleration: float = 0.0
    command_timeout: float = 1.0
    odometry_noise: float = 0.0


def saturated(linear: float, angular: float, robot: RobotSettings) -> Tuple[float, float]:
    """Return the speeds that a robot drives at when it is asked for some: none above its limits.

    All are reduced by the same factor, so that it drives the same curve, only slower.

    :param linear: m/s, finite
    :param angular: rad/s, finite
    :param robot: what it is like
    :returns: m/s and rad/s
    """
    # Of what is huge, only the curve matters; and no product may overflow.
    scale = max(1.0, abs(linear) / _HUGE, abs(angular) / _HUGE)
    linear, angular = linear / scale, angular / scale
    linear, angular = _reduced(linear, angular, abs(linear), robot.max_linear_velocity)
    linear, angular = _reduced(linear, angular, abs(angular), robot.max_angular_velocity)
    wheels = wheel_speeds(linear, angular, robot.wheel_separation, robot.wheel_radius)
    fastest = max(abs(wheels.left), abs(wheels.right))
    return _reduced(linear, angular, fastest, robot.max_wheel_speed)


def _reduced(linear: float, angular: float, value: float, limit: float) -> Tuple[float, float]:
    """Return both speeds times a factor that takes a value down to its limit."""
    if value <= limit:
        return linear, angular
    return linear / value * limit, angular / value * limit


def ramp_time(start: Wheels, end: Wheels, acceleration: float) -> float:
    """Return how long the wheels take to come from some speeds to others, s.

    Both take the same time, so that the curve changes evenly too.

    :param start: rad/s
    :param end: rad/s
    :param acceleration: most for either, rad/s^2; 0 for no limit
    """
    if acceleration <= 0.0:
        return 0.0
    return max(abs(end.left - start.left), abs(end.right - start.right)) / acceleration


def between(start: Wheels, end: Wheels, part: float) -> Wheels:
    """Return speeds on the straight line from some to others.

    :param start: rad/s
    :param end: rad/s
    :param part: 0 for the start, 1 for the end
    """
    return Wheels(
        start.left + (end.left - start.left) * part,
        start.right + (end.right - start.right) * part,
    )
