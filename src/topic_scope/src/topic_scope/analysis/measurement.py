"""Measured value with its uncertainty, or the reason why it cannot be measured."""

import math
from typing import NamedTuple, Optional


class Measurement(NamedTuple):
    """Measured value with its uncertainty.

    :param value: in the unit of the figure; None where it cannot be measured
    :param uncertainty: how far off the value may be, in the same unit
    :param reason: why it cannot be measured, in words
    """

    value: Optional[float]
    uncertainty: float = 0.0
    reason: str = ""

    def times(self, factor: float) -> "Measurement":
        """Return it in another unit."""
        if self.value is None:
            return self
        return measured(factor * self.value, factor * self.uncertainty)


def unmeasurable(reason: str) -> Measurement:
    """Return a measurement without a value.

    :param reason: why, in words
    """
    return Measurement(None, 0.0, reason)


def measured(value: float, uncertainty: float) -> Measurement:
    """Return a measurement; one that overflows has no value."""
    if not math.isfinite(value) or not math.isfinite(uncertainty):
        return unmeasurable("the numbers are too large")
    return Measurement(value, uncertainty)


def between(low: float, high: float, more: float = 0.0) -> Measurement:
    """Return a measurement that lies between two values.

    :param low: the one
    :param high: the other one
    :param more: how far beyond these it may lie
    """
    return measured(low + (high - low) / 2.0, abs(high - low) / 2.0 + more)
