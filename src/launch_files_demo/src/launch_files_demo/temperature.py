# Pure: knows no ROS.
"""A temperature that rises and falls, as a sensor with noise measures it."""

import math
import random

#: What the sensor can measure, degrees Celsius.
COLDEST, WARMEST = -10.0, 40.0
#: Variance of what it measures, in squared degrees.
VARIANCE = 0.5
#: Time from one warmest moment to the next, s.
PERIOD_S = 60.0

_MEAN, _SWING = 15.0, 20.0


def true_temperature(time: float) -> float:
    """Return how warm it is, degrees Celsius.

    :param time: any time, s
    """
    return _MEAN + _SWING * math.sin(math.tau * (time / PERIOD_S % 1.0))


def measured(time: float, chance: random.Random) -> float:
    """Return what the sensor measures, degrees Celsius.

    :param time: any time, s
    :param chance: where its noise comes from
    """
    noise = chance.gauss(0.0, math.sqrt(VARIANCE))
    return min(max(true_temperature(time) + noise, COLDEST), WARMEST)
