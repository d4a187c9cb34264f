"""Poses in the plane, errors between them, and wrapped angles."""

import math
from typing import NamedTuple, Optional, Sequence


class Pose(NamedTuple):
    """Pose of a robot on the plane.

    :param x: position [m]
    :param y: position [m]
    :param theta: heading, counter-clockwise from the x axis [rad]
    """

    x: float
    y: float
    theta: float


class Goal(NamedTuple):
    """Target pose of a robot.

    :param x: position [m]
    :param y: position [m]
    :param theta: heading, rad; None for any heading
    """

    x: float
    y: float
    theta: Optional[float] = None

    def __str__(self) -> str:
        heading = "" if self.theta is None else f", theta {self.theta:g} rad"
        return f"x {self.x:g} m, y {self.y:g} m{heading}"


class Errors(NamedTuple):
    """Distance and angles between a robot and its goal.

    :param distance: [m]
    :param direction: angle from the robot's heading to the goal, counter-clockwise [rad]
    :param heading: angle from the robot's heading to the goal's heading, counter-clockwise [rad]; 0
        if the goal has no heading
    """

    distance: float
    direction: float
    heading: float


def wrap(angle: float) -> float:
    """Return the same angle between -pi and pi.

    :param angle: [rad]
    """
    return math.remainder(angle, 2.0 * math.pi)


def errors(pose: Pose, goal: Goal) -> Errors:
    """Return distance and angles between a robot and its goal.

    :param pose: of the robot
    :param goal: target pose
    """
    dx, dy = goal.x - pose.x, goal.y - pose.y
    heading = 0.0 if goal.theta is None else wrap(goal.theta - pose.theta)
    return Errors(math.hypot(dx, dy), wrap(math.atan2(dy, dx) - pose.theta), heading)


def pose_fault(position: Sequence[float], orientation: Sequence[float]) -> str:
    """Return why a robot's pose is invalid; empty if it is valid.

    :param position: its coordinates [m]
    :param orientation: the components of its quaternion
    """
    length = math.hypot(*orientation[:2]) + math.hypot(*orientation[2:])
    if not all(map(math.isfinite, (*position, length * length))):
        return f"position {_listed(position)}, orientation {_listed(orientation)}: not finite"
    if not length * length:
        return f"orientation {_listed(orientation)}: not a quaternion"
    return ""


def _listed(parts: Sequence[float]) -> str:
    return "({})".format(", ".join(f"{part:g}" for part in parts))


def heading_of(x: float, y: float, z: float, w: float) -> float:
    """Return the heading of a robot in the plane [rad]; NaN if a component is not finite.

    The quaternion need not be normalised: people type z 1, w 1 for a quarter turn.

    :param x: component of the quaternion, like the others
    """
    if not math.isfinite(x + y + z + w):
        return math.nan
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
