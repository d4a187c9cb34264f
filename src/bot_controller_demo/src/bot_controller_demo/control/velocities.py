"""Commands to a robot with two wheels, and the limits of each model."""

from typing import Dict, NamedTuple


class Velocity(NamedTuple):
    """Velocity of a robot.

    :param linear: forward, m/s
    :param angular: counter-clockwise, rad/s
    """

    linear: float
    angular: float


STOP = Velocity(0.0, 0.0)


class Limits(NamedTuple):
    """The largest velocities, in either direction.

    :param linear: m/s
    :param angular: rad/s
    """

    linear: float
    angular: float


#: What the makers state of their robots.
MODELS: Dict[str, Limits] = {
    "burger": Limits(0.22, 2.84),
    "waffle": Limits(0.26, 1.82),
    "waffle_pi": Limits(0.26, 1.82),
}


def saturate(velocity: Velocity, limits: Limits) -> Velocity:
    """Return a velocity within limits, of the same curvature.

    Both parts are reduced together: cut off each by itself, the robot would leave its path.

    :param velocity: what is wanted
    :param limits: above 0
    """
    excess = max(abs(velocity.linear) / limits.linear, abs(velocity.angular) / limits.angular)
    if excess <= 1.0:
        return velocity
    return Velocity(velocity.linear / excess, velocity.angular / excess)


def clamp(velocity: Velocity, limits: Limits) -> Velocity:
    """Return a velocity with each part within its limit.

    :param velocity: what is wanted
    :param limits: from 0
    """
    linear = max(-limits.linear, min(limits.linear, velocity.linear))
    return Velocity(linear, max(-limits.angular, min(limits.angular, velocity.angular)))
