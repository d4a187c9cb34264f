"""Seeded noise: one seed gives one sequence, on every machine and at every rate."""

import math
import random

from basic_comms.signals.waveforms import TWO_PI

#: The standard deviation of the Gaussian noise before it is cut, as a part of the amplitude.
SIGMA = 1.0 / 3.0


class Noise:
    """A white sequence of independent random values in [-1, 1].

    Only ``random.Random.random`` is used, the one generator whose sequence Python promises to keep.

    :param seed: start of the sequence, >= 0
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed).random

    def uniform(self) -> float:
        """Return the next uniformly distributed value.

        :returns: value in [-1, 1), mean 0, standard deviation 1 / sqrt(3)
        """
        return 2.0 * self._random() - 1.0

    def gaussian(self) -> float:
        """Return the next value of a normal law of standard deviation 1/3, cut at three of them.

        A value beyond [-1, 1], one in 370, is drawn again. That leaves a standard deviation of
        0.9866 / 3. The normal values are made by the Box-Muller transform.

        :returns: value in [-1, 1], mean 0
        """
        while True:
            radius = SIGMA * math.sqrt(-2.0 * math.log(1.0 - self._random()))
            value = radius * math.cos(TWO_PI * self._random())
            if -1.0 <= value <= 1.0:
                return value
