"""Random velocities, and turns away from walls."""

import math
import random
from typing import Tuple

from bot_controller_demo.control.velocities import Velocity

#: Minimum and maximum.
Interval = Tuple[float, float]

#: Turn at a wall [rad]: from parallel to the wall to straight back.
_TURN_AWAY: Interval = (0.5 * math.pi, math.pi)


class Wanderer:
    """Source of random velocities.

    :param seed: of the sequence; 0 for a different one each time
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed or None)
        self._turning_rate, self._turning_s = 0.0, 0.0

    def draw(
        self, linear: Interval, angular: Interval, period: float = 0.0, touches: bool = False
    ) -> Velocity:
        """Return the next velocity.

        At a wall it is a turn in place at the highest allowed rate, until the robot has turned away
        by a random angle, or a random velocity if no turn is allowed.

        :param linear: minimum and maximum speed [m/s]
        :param angular: minimum and maximum turning rate [rad/s]
        :param period: duration of the velocity [s]
        :param touches: whether the robot has touched a wall since the last one
        """
        if touches and self._turning_s <= 0.0 and any(angular):
            self._turning_rate = max(angular, key=lambda rate: (abs(rate), self._random.random()))
            self._turning_s = self._random.uniform(*_TURN_AWAY) / abs(self._turning_rate)
        if self._turning_s > 0.0:
            self._turning_s -= period
            return Velocity(0.0, self._turning_rate)
        return Velocity(self._random.uniform(*linear), self._random.uniform(*angular))
