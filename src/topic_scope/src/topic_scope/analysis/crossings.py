"""Level crossings and gaps of a trace."""

from typing import Tuple

import numpy


def rises(
    times: numpy.ndarray, values: numpy.ndarray, level: float, band: float, firsts: numpy.ndarray
) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return where a trace crosses a level upwards.

    The crossing lies between the last sample surely below the level and the first sample surely
    above it, with no gap between them.

    :param times: ascending [s]
    :param values: finite
    :param level: the level
    :param band: distance from the level beyond which a sample is surely below or above it
    :param firsts: indices returned by :func:`after_gaps`
    :returns: three rows: time of the crossing [s]; its uncertainty [s]; the step from the sample
        before to the sample after it, in the unit of the values times seconds; and the number of
        gaps before each crossing
    """
    side = (values > level + band).astype(numpy.int8) - (values < level - band)
    sure = numpy.flatnonzero(side)
    surely, gaps = side[sure], numpy.searchsorted(firsts, sure, "right")
    is_rise = (surely[:-1] < 0) & (surely[1:] > 0) & (gaps[:-1] == gaps[1:])
    departures, arrivals = sure[:-1][is_rise], sure[1:][is_rise]
    # Of the samples in the band, take the last before the level and the first after it.
    below = numpy.flatnonzero(values < level)
    last = below[numpy.searchsorted(below, arrivals) - 1]
    jumps, steps = values[last + 1] - values[last], times[last + 1] - times[last]
    moments = times[last] + (level - values[last]) / jumps * steps
    doubts = numpy.maximum(moments - times[departures], times[arrivals] - moments)
    return numpy.array([moments, doubts, jumps * steps]), gaps[1:][is_rise]


def after_gaps(times: numpy.ndarray, longest: float) -> numpy.ndarray:
    """Return the indices of the first sample after each gap.

    :param times: ascending [s]
    :param longest: a gap is longer than this [s]
    """
    return numpy.flatnonzero(numpy.diff(times) > longest) + 1


def longest_stretch(times: numpy.ndarray, longest: float) -> slice:
    """Return the slice of the longest part of a trace without a gap.

    :param times: ascending [s]
    :param longest: a gap is longer than this [s]
    """
    limits = numpy.concatenate([[0], after_gaps(times, longest), [len(times)]])
    best = int(numpy.argmax(numpy.diff(limits)))
    return slice(int(limits[best]), int(limits[best + 1]))
