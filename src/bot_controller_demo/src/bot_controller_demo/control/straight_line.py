"""The course's exercise: a straight line, of which the distance left is known in closed form."""

import math
from typing import List


def distance_left(time: float, distance: float, gain: float, limit: float = math.inf) -> float:
    """Return what is left of the way under v = min(K d, limit), m.

    The speed is the limit first, and the distance falls in proportion to the time. From where
    K d is the limit, it falls exponentially.

    :param time: since the start, s
    :param distance: of the whole way, m
    :param gain: K, 1/s
    :param limit: of the speed, m/s
    """
    knee = min(distance, limit / gain)
    at_knee = (distance - knee) / limit
    if time < at_knee:
        return distance - limit * time
    return knee * math.exp(-gain * (time - at_knee))


def time_when(left: float, distance: float, gain: float, limit: float = math.inf) -> float:
    """Return when so much is left of the way, s.

    :param left: above 0 and up to the whole way, m
    :param distance: of the whole way, m
    :param gain: K, 1/s
    :param limit: of the speed, m/s
    """
    knee = min(distance, limit / gain)
    if left >= knee:
        return (distance - left) / limit
    return (distance - knee) / limit + math.log(knee / left) / gain


def sampled(
    distance: float, gain: float, period: float, count: int, limit: float = math.inf
) -> List[float]:
    """Return what is left at each sample, m: the speed is computed there and held until the next.

    :param distance: of the whole way, m
    :param gain: K, 1/s
    :param period: from one sample to the next, s
    :param count: of samples
    :param limit: of the speed, m/s
    """
    left = [distance]
    while len(left) < count:
        left.append(left[-1] - period * min(gain * left[-1], limit))
    return left
