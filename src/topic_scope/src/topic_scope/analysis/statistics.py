"""What is measured of a trace."""

import math
from typing import Dict, Optional, Tuple

import numpy

#: A trace has to leave its mean by this part of its range before a crossing of the mean counts:
#: noise on it makes no periods.
HYSTERESIS = 0.1


def measure(
    times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf
) -> Dict[str, Optional[float]]:
    """Measure a trace.

    :param times: ascending, s
    :param values: the samples; what is not finite counts for the rate only
    :param longest: how far apart samples of one line may be, s: no period is across a gap
    :returns: rate in Hz, the latest value, min, max, peak to peak (vpp), mean, rms, standard
        deviation, frequency in Hz, and the part of the samples that is not finite (nan); None for
        what there is not
    """
    result: Dict[str, Optional[float]] = dict.fromkeys(
        ("rate", "value", "min", "max", "vpp", "mean", "rms", "deviation", "frequency", "nan")
    )
    if len(times) and times[-1] > times[0]:
        result["rate"] = (len(times) - 1) / float(times[-1] - times[0])
    finite = numpy.isfinite(values)
    if len(values):
        result["nan"] = 1.0 - float(finite.mean())
    times, values = times[finite], values[finite]
    if len(values):
        # Scaled, so that squares and sums of large numbers do not overflow.
        scale = float(numpy.abs(values).max()) or 1.0
        parts = values / scale
        result["value"] = float(values[-1])
        low, high = float(values.min()), float(values.max())
        result["min"], result["max"], result["vpp"] = low, high, _finite(high - low)
        mean = float(parts.mean())
        result["mean"] = _finite(mean * scale)
        # About the mean: of what is large and varies little, squares would keep no digit.
        result["deviation"] = _finite(math.sqrt(float(numpy.square(parts - mean).mean())) * scale)
        result["rms"] = _finite(math.sqrt(float(numpy.square(parts).mean())) * scale)
        result["frequency"] = frequency(times, parts, longest)
    return result


def frequency(
    times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf
) -> Optional[float]:
    """Return how often a trace crosses its mean upwards in a second, or downwards.

    The crossings are taken on the straight line between two samples, and whole periods only are
    counted.

    :param times: ascending, s
    :param values: finite, and of moderate size
    :param longest: see :func:`measure`
    :returns: the frequency in Hz, None if there is no whole period
    """
    low, high = values.min(), values.max()
    band = HYSTERESIS * (high - low)
    # Short pulses leave a mean that is close to where they come from on one side only.
    level = min(max(values.mean(), low + 2 * band), high - 2 * band)
    ups = rises(times, values, level, band)
    if len(ups) < 2:  # of two periods, one may begin too close to an end to be seen
        ups = rises(times, -values, -level, band)
    periods = numpy.diff(ups)
    gaps = numpy.concatenate([[0], numpy.cumsum(numpy.diff(times) > longest)])
    if gaps[-1]:
        first, last = times.searchsorted(ups, "right") - 1, times.searchsorted(ups, "left")
        periods = periods[gaps[first[:-1]] == gaps[last[1:]]]
    length = float(periods.sum())  # the stamps of a simulation that stands are the same
    return len(periods) / length if length > 0.0 else None


def rises(times: numpy.ndarray, values: numpy.ndarray, level: float, band: float) -> numpy.ndarray:
    """Return when a trace crosses a level upwards, s.

    :param times: ascending, s
    :param values: finite
    :param level: the level
    :param band: how far the trace has to get from the level before a crossing counts
    """
    side = (values > level + band).astype(numpy.int8) - (values < level - band)
    sure = numpy.flatnonzero(side)
    arrivals = sure[1:][(side[sure[:-1]] < 0) & (side[sure[1:]] > 0)]
    # Of all samples on the way, the last one before the level and the one behind it.
    indices = numpy.where(values < level, numpy.arange(len(values)), 0)
    last = numpy.maximum.accumulate(indices)[arrivals]
    part = (level - values[last]) / (values[last + 1] - values[last])
    moments: numpy.ndarray = times[last] + part * (times[last + 1] - times[last])
    return moments


def edges(
    times: numpy.ndarray, values: numpy.ndarray, level: float, band: float
) -> "Tuple[numpy.ndarray, numpy.ndarray]":
    """Return when a trace crosses a level upwards, and when downwards; as :func:`rises`."""
    return rises(times, values, level, band), rises(times, -values, -level, band)


def longest_stretch(times: numpy.ndarray, longest: float) -> slice:
    """Return which samples are the longest part of a trace without a gap.

    :param times: ascending, s
    :param longest: a gap is longer than this, s
    """
    ends = numpy.flatnonzero(numpy.diff(times) > longest) + 1
    limits = numpy.concatenate([[0], ends, [len(times)]])
    best = int(numpy.argmax(numpy.diff(limits)))
    return slice(int(limits[best]), int(limits[best + 1]))


def _finite(number: float) -> Optional[float]:
    return number if math.isfinite(number) else None
