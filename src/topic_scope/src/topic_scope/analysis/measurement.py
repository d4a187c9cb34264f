"""Measured value with its uncertainty, or the reason for its absence."""

import math
from typing import NamedTuple, Optional


class Measurement(NamedTuple):
    """Measured value with its uncertainty.

    :param value: in the unit of the quantity; None if it cannot be measured
    :param uncertainty: bound of the error, in the same unit
    :param reason: why it cannot be measured
    """

    value: Optional[float]
    uncertainty: float = 0.0
    reason: str = ""

    def times(self, factor: float) -> "Measurement":
        """Return the measurement in another unit."""
        if self.value is None:
            return self
        return measured(factor * self.value, factor * self.uncertainty)


def unmeasurable(reason: str) -> Measurement:
    """Return a measurement without a value.

    :param reason: why it cannot be measured
    """
    return Measurement(None, 0.0, reason)


def measured(value: float, uncertainty: float) -> Measurement:
    """Return a measurement; on overflow, one without a value."""
    if not math.isfinite(value) or not math.isfinite(uncertainty):
        return unmeasurable("numbers too large")
    return Measurement(value, uncertainty)


def between(low: float, high: float, more: float = 0.0) -> Measurement:
    """Return the measurement of a quantity between two bounds.

    :param low: lower bound
    :param high: upper bound
    :param more: additional uncertainty
    """
    return measured(low + (high - low) / 2.0, abs(high - low) / 2.0 + more)
