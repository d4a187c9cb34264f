"""Kinematics of a differential-drive robot, in closed form without accumulated error.

At constant wheel speeds, the robot drives a circular arc. A turn of 2h over a path of length d
moves it along a chord of length d sin(h) / h, at the mean of the headings before and after
(Siegwart, Nourbakhsh: Autonomous Mobile Robots, section 3.2). Lengths are in m, angles in rad,
counter-clockwise, speeds in m/s and rad/s (REP 103).
"""

import math
from typing import NamedTuple, Tuple

#: Below this half turn, rad, the series of sin(h) / h is exact to the last bit.
_SMALL = 1e-4


def wrapped(angle: float) -> float:
    """Return the same direction as an angle in [-pi, pi].

    :param angle: [rad]
    """
    return math.remainder(angle, math.tau)


def chord(distance: float, turn: float) -> float:
    """Return the length of the straight line between the ends of an arc, m; below 0 backwards.

    :param distance: length of the arc, m; below 0 backwards
    :param turn: change of the heading on it [rad]
    """
    half = 0.5 * turn
    ratio = math.sin(half) / half if abs(half) > _SMALL else 1.0 - half * half / 6.0
    return distance * ratio


class Pose(NamedTuple):
    """Pose of a robot in the plane.

    :ivar x: [m]
    :ivar y: [m]
    :ivar theta: heading, rad, 0 along x
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def moved(self, distance: float, turn: float) -> "Pose":
        """Return the pose at the end of an arc; its heading is in [-pi, pi].

        :param distance: length of the arc, m; below 0 backwards
        :param turn: change of the heading on it [rad]
        """
        direction, length = self.theta + 0.5 * turn, chord(distance, turn)
        return Pose(
            self.x + length * math.cos(direction),
            self.y + length * math.sin(direction),
            wrapped(self.theta + turn),
        )


class Wheels(NamedTuple):
    """Speeds [rad/s] or angles [rad] of the left and the right wheel."""

    left: float = 0.0
    right: float = 0.0


def wheel_speeds(linear: float, angular: float, separation: float, radius: float) -> Wheels:
    """Return the wheels' speeds of a robot [rad/s].

    :param linear: speed forward [m/s]
    :param angular: rate of turn [rad/s]
    :param separation: distance between the wheels [m]
    :param radius: of the wheels [m]
    """
    difference = 0.5 * separation * angular
    return Wheels((linear - difference) / radius, (linear + difference) / radius)


def body_speeds(wheels: Wheels, separation: float, radius: float) -> Tuple[float, float]:
    """Return a robot's speed [m/s] and rate of turn [rad/s].

    :param wheels: the wheels' speeds [rad/s]
    :param separation: distance of the wheels [m]
    :param radius: of the wheels [m]
    """
    left, right = wheels.left * radius, wheels.right * radius
    return 0.5 * (left + right), (right - left) / separation
