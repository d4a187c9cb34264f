# Pure: knows no ROS.
"""Conversions between seconds and integer nanoseconds."""

import math

import numpy

#: Nanoseconds in a second.
NS = 10**9
#: Larger than the rounding of a time since the epoch as a float [ns].
ROUNDED_NS = 250
#: Placeholder for a message without a valid stamp.
NO_TIME = -(1 << 62)
#: Largest valid time [s]: differences in nanoseconds fit in 64 bits.
LARGEST_S = 4.3e9
_ENDS = int(LARGEST_S) * NS


def to_ns(seconds: float) -> int:
    """Return a time in whole nanoseconds.

    :param seconds: the time [s]; infinity for the earliest or the latest time
    """
    if abs(seconds) >= LARGEST_S:
        return _ENDS if seconds > 0 else -_ENDS
    whole = math.floor(seconds)  # the fraction is converted separately, to keep all digits
    return whole * NS + round((seconds - whole) * NS)


def to_seconds(nanoseconds: int) -> float:
    """Return a time in seconds; reverses :func:`to_ns`, including infinity."""
    return nanoseconds / NS if abs(nanoseconds) < _ENDS else math.copysign(math.inf, nanoseconds)


def shifted(nanoseconds: int, by: int) -> int:
    """Return a time shifted by nanoseconds; infinite if the time or the shift is."""
    for one in (nanoseconds, by):
        if abs(one) >= _ENDS:
            return _ENDS if one > 0 else -_ENDS
    return min(max(nanoseconds + by, -_ENDS), _ENDS)


def array_to_ns(seconds: numpy.ndarray) -> numpy.ndarray:
    """Return times in whole nanoseconds.

    :param seconds: the times [s]; invalid or too large times become :data:`NO_TIME`
    """
    valid = numpy.abs(seconds) <= LARGEST_S  # false for NaN
    whole = numpy.floor(numpy.where(valid, seconds, 0.0))
    rest = numpy.rint((numpy.where(valid, seconds, 0.0) - whole) * NS)
    times = whole.astype(numpy.int64) * NS + rest.astype(numpy.int64)
    return numpy.where(valid, times, NO_TIME)


def exact_seconds(nanoseconds: int) -> str:
    """Return a time in s, without rounding it."""
    seconds, rest = divmod(abs(nanoseconds), NS)
    return f"{'-' if nanoseconds < 0 else ''}{seconds}.{rest:09}"
