"""Control laws: from the errors of a robot to its velocity.

Both are proportional: the larger the error, the faster.
"""

import math
from typing import Callable, Dict, NamedTuple

from bot_controller_demo.control.geometry import Errors
from bot_controller_demo.control.velocities import Velocity


class Gains(NamedTuple):
    """Gains from errors to velocities.

    :param linear: of the distance, 1/s
    :param angular: of an angle, 1/s
    """

    linear: float
    angular: float


#: Where the course's law comes to its goals: kp_angular in units of kp_linear, and the least
#: linear_tolerance, m. Of 100 random goals with a burger's limits none is missed there; of 40, 28
#: are at a ratio of 0.9, 8 at 2.4, and 35 at 2.0 with a tolerance of 0.05 m.
COURSE_RATIOS = (1.5, 2.2)
COURSE_LEAST_TOLERANCE = 0.1
#: Where the course's law starts to turn to the last heading, m.
_COURSE_BLENDS_FROM_M = 0.5


def settling(errors: Errors, gains: Gains) -> Velocity:
    """Drive as far as the robot faces its goal; the last heading comes afterwards.

    v = K d cos(a)^2, and 0 where the goal is behind; w = K a. The cosine takes the speed away while
    the robot faces aside: squared, it keeps the path below 1.07 times the straight one with the
    course's gains, at any distance (1.12 without the square). The distance never grows.

    :param errors: between the robot and its goal
    :param gains: of the law
    """
    forward = max(0.0, math.cos(errors.direction))
    speed = gains.linear * errors.distance * forward**2
    return Velocity(speed, gains.angular * errors.direction)


def course(errors: Errors, gains: Gains) -> Velocity:
    """Drive whatever the direction, and turn more and more to the last heading on the way.

    The law of the course. Near the goal it steers away from it, see :func:`may_circle`.

    :param errors: between the robot and its goal
    :param gains: of the law
    """
    towards = min(1.0, errors.distance / _COURSE_BLENDS_FROM_M)
    angle = towards * errors.direction + (1.0 - towards) * errors.heading
    return Velocity(gains.linear * errors.distance, gains.angular * angle)


def may_circle(gains: Gains, linear_tolerance: float) -> bool:
    """Tell whether the course's law may circle a goal for ever, and never come to it.

    What matters is how the gains compare. With too little turning the robot does not come round to
    the goal; with too much it looks along the last heading while it still drives.

    :param gains: of the law
    :param linear_tolerance: distance at which the goal counts as reached, m
    """
    least, most = (ratio * gains.linear for ratio in COURSE_RATIOS)
    return linear_tolerance < COURSE_LEAST_TOLERANCE or not least <= gains.angular <= most


LAWS: Dict[str, Callable[[Errors, Gains], Velocity]] = {"settling": settling, "course": course}
