"""Statistics of a trace: rate, minimum, maximum, mean, RMS, standard deviation, NaN share."""

import math
from typing import Dict, Optional

import numpy


def measure(times: numpy.ndarray, values: numpy.ndarray) -> Dict[str, Optional[float]]:
    """Return exact statistics of the samples of a trace.

    :param times: ascending [s]
    :param values: the samples; non-finite values count for the rate only
    :returns: rate in Hz, the latest value, min, max, peak to peak (vpp), mean, rms, standard
        deviation, and the fraction of non-finite samples (nan); None if undefined
    """
    result: Dict[str, Optional[float]] = dict.fromkeys(
        ("rate", "value", "min", "max", "vpp", "mean", "rms", "deviation", "nan")
    )
    finite = numpy.isfinite(values)
    if not finite.all():
        # The end of a line is marked by a NaN at the time of its last sample, not a sample.
        ends = numpy.flatnonzero(numpy.isnan(values[1:]) & (times[1:] == times[:-1])) + 1
        times, values, finite = (numpy.delete(row, ends) for row in (times, values, finite))
    if len(times) and times[-1] > times[0]:
        result["rate"] = (len(times) - 1) / float(times[-1] - times[0])
    if len(values):
        count = int(numpy.count_nonzero(finite))
        result["nan"] = 1.0 - count / len(values)
        if count < len(values):
            values = values[finite]
    if len(values):
        low, high = float(values.min()), float(values.max())
        # Scaled so that squares and sums of large numbers do not overflow.
        scale = max(-low, high) or 1.0
        parts = values / scale
        result["value"] = float(values[-1])
        result["min"], result["max"], result["vpp"] = low, high, _finite(high - low)
        mean = float(parts.mean())
        result["mean"] = _finite(mean * scale)
        # About the mean: squares of large, nearly constant values would lose all digits.
        result["deviation"] = _finite(math.sqrt(float(numpy.square(parts - mean).mean())) * scale)
        result["rms"] = _finite(math.sqrt(float(numpy.square(parts).mean())) * scale)
    return result


def _finite(number: float) -> Optional[float]:
    return number if math.isfinite(number) else None
