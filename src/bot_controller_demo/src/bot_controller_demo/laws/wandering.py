"""Random velocities, the same ones for the same seed."""

import random
from typing import Tuple

from bot_controller_demo.laws.velocities import Velocity

Interval = Tuple[float, float]


class Wanderer:
    """Draws velocities.

    :param seed: what the sequence is made from; 0 for another one each time
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed or None)

    def draw(self, linear: Interval, angular: Interval) -> Velocity:
        """Return the next velocity.

        :param linear: least and largest speed, m/s
        :param angular: least and largest turning rate, rad/s
        """
        return Velocity(self._random.uniform(*linear), self._random.uniform(*angular))
