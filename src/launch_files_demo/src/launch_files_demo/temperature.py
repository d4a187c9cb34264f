# Pure: knows no ROS.
"""Simulated temperature, and its measurement by a noisy sensor."""

import math
import random

#: Range of the sensor [degrees Celsius].
COLDEST, WARMEST = -10.0, 40.0
#: Variance of the measurement, in squared degrees.
VARIANCE = 0.5
#: Period of the temperature [s].
PERIOD_S = 60.0

_MEAN, _SWING = 15.0, 20.0


def true_temperature(time: float) -> float:
    """Return the temperature [degrees Celsius].

    :param time: any time [s]
    """
    return _MEAN + _SWING * math.sin(math.tau * (time / PERIOD_S % 1.0))


def measured(time: float, chance: random.Random) -> float:
    """Return a measurement [degrees Celsius].

    :param time: any time [s]
    :param chance: random generator of the noise
    """
    noise = chance.gauss(0.0, math.sqrt(VARIANCE))
    return min(max(true_temperature(time) + noise, COLDEST), WARMEST)
