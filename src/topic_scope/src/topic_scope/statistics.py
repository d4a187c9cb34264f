"""What is measured of a trace."""

import math
from typing import Dict, Optional

import numpy

#: A trace has to leave its mean by this part of its range before a crossing of the mean counts:
#: noise on it makes no periods.
HYSTERESIS = 0.1


def measure(times: numpy.ndarray, values: numpy.ndarray) -> Dict[str, Optional[float]]:
    """Measure a trace.

    :param times: ascending, s
    :param values: the samples; what is not finite counts for the rate only
    :returns: rate in Hz, min, max, mean, rms, frequency in Hz, and the part of the samples that
        is not finite; None for what there is not
    """
    result: Dict[str, Optional[float]] = dict.fromkeys(
        ("rate", "min", "max", "mean", "rms", "frequency", "nan")
    )
    if len(times) > 1:
        result["rate"] = (len(times) - 1) / float(times[-1] - times[0])
    finite = numpy.isfinite(values)
    if len(values):
        result["nan"] = 1.0 - float(finite.mean())
    times, values = times[finite], values[finite]
    if len(values):
        # Scaled, so that squares and sums of large numbers do not overflow.
        scale = float(numpy.abs(values).max()) or 1.0
        parts = values / scale
        result["min"], result["max"] = float(values.min()), float(values.max())
        result["mean"] = _finite(float(parts.mean()) * scale)
        result["rms"] = _finite(math.sqrt(float(numpy.square(parts).mean())) * scale)
        result["frequency"] = frequency(times, parts)
    return result


def frequency(times: numpy.ndarray, values: numpy.ndarray) -> Optional[float]:
    """Return how often a trace crosses its mean upwards in a second.

    The crossings are taken on the straight line between two samples, and whole periods only are
    counted.

    :param times: ascending, s
    :param values: finite, and of moderate size
    :returns: the frequency in Hz, None if there is no whole period
    """
    mean = values.mean()
    band = HYSTERESIS * (values.max() - values.min())
    side = (values > mean + band).astype(numpy.int8) - (values < mean - band)
    sure = numpy.flatnonzero(side)
    highs = sure[1:][(side[sure[:-1]] < 0) & (side[sure[1:]] > 0)]
    if len(highs) < 2:
        return None
    # Of all samples on the way up, the last one below the mean and the one behind it.
    indices = numpy.arange(len(values))
    below = numpy.maximum.accumulate(numpy.where(values < mean, indices, 0))[highs]
    part = (mean - values[below]) / (values[below + 1] - values[below])
    moments = times[below] + part * (times[below + 1] - times[below])
    return (len(moments) - 1) / float(moments[-1] - moments[0])


def _finite(number: float) -> Optional[float]:
    return number if math.isfinite(number) else None
