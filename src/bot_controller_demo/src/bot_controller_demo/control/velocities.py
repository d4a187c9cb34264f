"""Commands to a differential-drive robot, and the limits of each model."""

from typing import Dict, NamedTuple


class Velocity(NamedTuple):
    """Velocity of a robot.

    :param linear: forward [m/s]
    :param angular: counter-clockwise [rad/s]
    """

    linear: float
    angular: float


STOP = Velocity(0.0, 0.0)


class Limits(NamedTuple):
    """The largest velocities, in either direction.

    :param linear: [m/s]
    :param angular: [rad/s]
    """

    linear: float
    angular: float


#: Limits as specified by the manufacturers.
MODELS: Dict[str, Limits] = {
    "burger": Limits(0.22, 2.84),
    "waffle": Limits(0.26, 1.82),
    "waffle_pi": Limits(0.26, 1.82),
}


def saturate(velocity: Velocity, limits: Limits) -> Velocity:
    """Return a velocity within limits, with the same curvature.

    Both components are scaled together: clipped separately, the robot would leave its path.

    :param velocity: requested velocity
    :param limits: above 0
    """
    excess = max(abs(velocity.linear) / limits.linear, abs(velocity.angular) / limits.angular)
    if excess <= 1.0:
        return velocity
    return Velocity(velocity.linear / excess, velocity.angular / excess)


def clamp(velocity: Velocity, limits: Limits) -> Velocity:
    """Return a velocity with each component clipped to its limit.

    :param velocity: requested velocity
    :param limits: not negative
    """
    linear = max(-limits.linear, min(limits.linear, velocity.linear))
    return Velocity(linear, max(-limits.angular, min(limits.angular, velocity.angular)))
