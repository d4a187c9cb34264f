"""Intervals of the phase of a sine, from one sample and from several.

An interval is a pair (centre, half width) in rad. Phases that differ by whole turns are equal.
"""

import math
from typing import List, Sequence, Tuple

Interval = Tuple[float, float]

HALF_TURN = math.pi
TURN = 2.0 * math.pi
CREST = 0.5 * math.pi


def phases_of_sine(value: float, tolerance: float) -> List[Interval]:
    """Find every phase at which a unit sine may have a measured value.

    :param value: measured value of the sine, 1 at the crest
    :param tolerance: largest error of the value
    :returns: the rising and the falling phases; one interval around a crest, where both meet;
        none if no sine reaches the value
    """
    low = value - tolerance
    high = value + tolerance
    if low > 1.0 or high < -1.0:
        return []
    first = math.asin(max(low, -1.0))
    last = math.asin(min(high, 1.0))
    if high >= 1.0:
        return [(CREST, CREST - first)]
    if low <= -1.0:
        return [(-CREST, CREST + last)]
    rising = 0.5 * (first + last)
    half = 0.5 * (last - first)
    return [(rising, half), (HALF_TURN - rising, half)]


def intersect(predicted: Sequence[Interval], measured: Sequence[Interval]) -> List[Interval]:
    """Return the part of each measured interval that overlaps a predicted interval.

    :param predicted: phases that are compatible with the earlier samples
    :param measured: phases that are compatible with the newest sample
    :returns: phases compatible with all samples, at most one interval per measured interval
    """
    agreed = []
    for centre, half in measured:
        low, high = math.inf, -math.inf
        for guess, doubt in predicted:
            offset = math.remainder(guess - centre, TURN)
            first = max(-half, offset - doubt)
            last = min(half, offset + doubt)
            if first <= last:
                low = min(low, first)
                high = max(high, last)
        if low <= high:
            agreed.append((centre + 0.5 * (low + high), 0.5 * (high - low)))
    return agreed


def nearest_first(intervals: Sequence[Interval], phase: float) -> List[Interval]:
    """Sort intervals by how far their centres are from a phase, the shorter way round.

    :param intervals: intervals to sort
    :param phase: phase to compare with [rad]
    :returns: the sorted intervals
    """
    return sorted(intervals, key=lambda interval: abs(math.remainder(interval[0] - phase, TURN)))
