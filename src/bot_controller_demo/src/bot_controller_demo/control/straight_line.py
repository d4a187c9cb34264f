"""Straight line, the course's exercise: the remaining distance in closed form."""

import math
from typing import List


def distance_left(time: float, distance: float, gain: float, limit: float = math.inf) -> float:
    """Return the remaining distance under v = min(K d, limit) [m].

    At first the speed is the limit, and the distance falls linearly. Once K d is below the limit,
    it falls exponentially.

    :param time: since the start [s]
    :param distance: at the start [m]
    :param gain: K [1/s]
    :param limit: of the speed [m/s]
    """
    knee = min(distance, limit / gain)
    at_knee = (distance - knee) / limit
    if time < at_knee:
        return distance - limit * time
    return knee * math.exp(-gain * (time - at_knee))


def time_when(left: float, distance: float, gain: float, limit: float = math.inf) -> float:
    """Return the time at which a distance remains [s].

    :param left: remaining distance, above 0 and up to the whole distance [m]
    :param distance: at the start [m]
    :param gain: K [1/s]
    :param limit: of the speed [m/s]
    """
    knee = min(distance, limit / gain)
    if left >= knee:
        return (distance - left) / limit
    return (distance - knee) / limit + math.log(knee / left) / gain


def sampled(
    distance: float, gain: float, period: float, count: int, limit: float = math.inf
) -> List[float]:
    """Return the remaining distance at each sample [m]; the speed is held between samples.

    :param distance: at the start [m]
    :param gain: K [1/s]
    :param period: sample period [s]
    :param count: number of samples
    :param limit: of the speed [m/s]
    """
    left = [distance]
    while len(left) < count:
        left.append(left[-1] - period * min(gain * left[-1], limit))
    return left
