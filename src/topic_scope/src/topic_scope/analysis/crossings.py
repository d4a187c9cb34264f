"""Level crossings and gaps of a trace."""

from typing import Tuple

import numpy


def rises(
    times: numpy.ndarray, values: numpy.ndarray, level: float, band: float, firsts: numpy.ndarray
) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return where a trace crosses a level upwards.

    It has crossed the level between the last sample that is surely below and the first one that is
    surely above, with no gap between them.

    :param times: ascending [s]
    :param values: finite
    :param level: the level
    :param band: how far from the level a sample is surely below or above
    :param firsts: what :func:`after_gaps` returns
    :returns: three rows: when [s]; how far off that may be [s]; and how far it is from the sample
        before to the one behind, in the unit of the values times seconds; and how many gaps are
        before each crossing
    """
    side = (values > level + band).astype(numpy.int8) - (values < level - band)
    sure = numpy.flatnonzero(side)
    surely, gaps = side[sure], numpy.searchsorted(firsts, sure, "right")
    is_rise = (surely[:-1] < 0) & (surely[1:] > 0) & (gaps[:-1] == gaps[1:])
    departures, arrivals = sure[:-1][is_rise], sure[1:][is_rise]
    # Of all samples on the way, the last one before the level and the one behind it.
    below = numpy.flatnonzero(values < level)
    last = below[numpy.searchsorted(below, arrivals) - 1]
    jumps, steps = values[last + 1] - values[last], times[last + 1] - times[last]
    moments = times[last] + (level - values[last]) / jumps * steps
    doubts = numpy.maximum(moments - times[departures], times[arrivals] - moments)
    return numpy.array([moments, doubts, jumps * steps]), gaps[1:][is_rise]


def after_gaps(times: numpy.ndarray, longest: float) -> numpy.ndarray:
    """Return the indices of the samples that are the first behind a gap.

    :param times: ascending [s]
    :param longest: a gap is longer than this [s]
    """
    return numpy.flatnonzero(numpy.diff(times) > longest) + 1


def longest_stretch(times: numpy.ndarray, longest: float) -> slice:
    """Return which samples are the longest part of a trace without a gap.

    :param times: ascending [s]
    :param longest: a gap is longer than this [s]
    """
    limits = numpy.concatenate([[0], after_gaps(times, longest), [len(times)]])
    best = int(numpy.argmax(numpy.diff(limits)))
    return slice(int(limits[best]), int(limits[best + 1]))
