"""Control laws: velocity of a robot from its errors.

Both are proportional.
"""

import math
from typing import Callable, Dict, NamedTuple

from bot_controller_demo.control.geometry import Errors
from bot_controller_demo.control.velocities import Velocity


class Gains(NamedTuple):
    """Gains from errors to velocities.

    :param linear: of the distance [1/s]
    :param angular: of an angle [1/s]
    """

    linear: float
    angular: float


#: Where the course's law converges: kp_angular in units of kp_linear, and the least
#: linear_tolerance [m]. With a burger's limits it reaches all of 100 random goals; of 40 goals it
#: reaches 28 at a ratio of 0.9, 8 at 2.4, and 35 at 2.0 with a tolerance of 0.05 m.
COURSE_RATIOS = (1.5, 2.2)
COURSE_LEAST_TOLERANCE = 0.1
#: Distance at which the course's law starts to turn to the final heading [m].
_COURSE_BLENDS_FROM_M = 0.5


def settling(errors: Errors, gains: Gains) -> Velocity:
    """Drive as far as the robot faces its goal; turn to the final heading afterwards.

    v = K d cos(a)^2, and 0 if the goal is behind; w = K a. The cosine reduces the speed while the
    robot faces aside: squared, it keeps the path below 1.07 times the straight line with the
    course's gains, at any distance (1.12 without the square). The distance never grows.

    :param errors: between the robot and its goal
    :param gains: of the law
    """
    forward = max(0.0, math.cos(errors.direction))
    speed = gains.linear * errors.distance * forward**2
    return Velocity(speed, gains.angular * errors.direction)


def course(errors: Errors, gains: Gains) -> Velocity:
    """Drive in any direction, and turn increasingly to the final heading on the way.

    This is the law of the course. Near the goal it steers away from it, see :func:`may_circle`.

    :param errors: between the robot and its goal
    :param gains: of the law
    """
    towards = min(1.0, errors.distance / _COURSE_BLENDS_FROM_M)
    angle = towards * errors.direction + (1.0 - towards) * errors.heading
    return Velocity(gains.linear * errors.distance, gains.angular * angle)


def may_circle(gains: Gains, linear_tolerance: float) -> bool:
    """Return whether the course's law may circle a goal forever without reaching it.

    The ratio of the gains decides. With a low angular gain the robot does not turn towards the goal
    in time; with a high one it faces the final heading while it still drives.

    :param gains: of the law
    :param linear_tolerance: distance at which the goal counts as reached [m]
    """
    least, most = (ratio * gains.linear for ratio in COURSE_RATIOS)
    return linear_tolerance < COURSE_LEAST_TOLERANCE or not least <= gains.angular <= most


LAWS: Dict[str, Callable[[Errors, Gains], Velocity]] = {"settling": settling, "course": course}
