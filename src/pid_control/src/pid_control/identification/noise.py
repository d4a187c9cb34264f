"""Autocorrelated noise: effective sample size, and covariance of sums."""

import numpy
from scipy.signal import lfilter

#: Most outputs that count as one, as a share of all.
_LARGEST_SHARE = 0.25


def outputs_per_independent_one(errors: numpy.ndarray) -> float:
    """Return how many successive residuals count as one independent sample.

    It is the integrated autocorrelation time 1 + 2 (r1 + r2 + ...), up to the first r <= 0 (Sokal:
    Monte Carlo methods in statistical mechanics, 1996, section 2); the effective sample size is the
    number of residuals divided by it.

    :param errors: the residuals, at even intervals
    :returns: at least 1
    """
    count = len(errors)
    spectrum = numpy.abs(numpy.fft.rfft(errors, 2 * count)) ** 2
    products = numpy.fft.irfft(spectrum)[: int(_LARGEST_SHARE * count)]
    if len(products) < 2 or products[0] <= 0.0:
        return 1.0
    alike = products[1:] / products[0]
    is_over = alike <= 0.0
    end = int(numpy.argmax(is_over)) if is_over.any() else len(alike)
    return max(1.0 + 2.0 * float(alike[:end].sum()), 1.0)


def covariance_of_sums(columns: numpy.ndarray, per_independent: float) -> numpy.ndarray:
    """Return the covariance of columns' products with noise of variance 1.

    The noise is AR(1), with correlations r^k: its r = (p - 1)/(p + 1) for p outputs per independent
    one (Box, Jenkins, Reinsel: Time Series Analysis, section 2.1).

    :param columns: one row per output
    :param per_independent: see :func:`outputs_per_independent_one`
    :returns: a square matrix, one row per column
    """
    alike = (per_independent - 1.0) / (per_independent + 1.0)
    before = lfilter([1.0], [1.0, -alike], columns, axis=0)
    after = lfilter([1.0], [1.0, -alike], columns[::-1], axis=0)[::-1]
    covariance: numpy.ndarray = columns.T @ (before + after - columns)
    return covariance
