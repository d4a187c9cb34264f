"""Limits of a robot's wheels: speed and acceleration."""

from typing import NamedTuple, Tuple

from diff_drive_sim.simulation.kinematics import Wheels, wheel_speeds

#: Faster than any robot [m/s] [rad/s].
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
    :ivar command_timeout: timeout of a command, s; 0 for unlimited
    :ivar odometry_noise: standard deviation of the error of a wheel's path after 1 m [m]
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
    """Return the speeds that a robot reaches for a command: none above its limits.

    Both are reduced by the same factor, so that it drives the same curve, only slower.

    :param linear: finite [m/s]
    :param angular: finite [rad/s]
    :param robot: its limits
    :returns: linear [m/s] and angular speed [rad/s]
    """
    # Scale huge commands down first, so that no product overflows; the curve is the same.
    scale = max(1.0, abs(linear) / _HUGE, abs(angular) / _HUGE)
    linear, angular = linear / scale, angular / scale
    linear, angular = _reduced(linear, angular, abs(linear), robot.max_linear_velocity)
    linear, angular = _reduced(linear, angular, abs(angular), robot.max_angular_velocity)
    wheels = wheel_speeds(linear, angular, robot.wheel_separation, robot.wheel_radius)
    fastest = max(abs(wheels.left), abs(wheels.right))
    return _reduced(linear, angular, fastest, robot.max_wheel_speed)


def _reduced(linear: float, angular: float, value: float, limit: float) -> Tuple[float, float]:
    """Return both speeds times the factor that reduces a value to its limit."""
    if value <= limit:
        return linear, angular
    return linear / value * limit, angular / value * limit


def ramp_time(start: Wheels, end: Wheels, acceleration: float) -> float:
    """Return the time for the wheels to change speed [s].

    Both take the same time, so that the curvature changes evenly, too.

    :param start: [rad/s]
    :param end: [rad/s]
    :param acceleration: limit for each wheel [rad/s^2]; 0 for no limit
    """
    if acceleration <= 0.0:
        return 0.0
    return max(abs(end.left - start.left), abs(end.right - start.right)) / acceleration


def between(start: Wheels, end: Wheels, part: float) -> Wheels:
    """Return linearly interpolated speeds.

    :param start: [rad/s]
    :param end: [rad/s]
    :param part: 0 for the start, 1 for the end
    """
    return Wheels(
        start.left + (end.left - start.left) * part,
        start.right + (end.right - start.right) * part,
    )
