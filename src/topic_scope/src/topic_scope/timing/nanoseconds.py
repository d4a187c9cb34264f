# Pure: knows no ROS.
"""Conversions between seconds and integer nanoseconds."""

import math

import numpy

#: Nanoseconds in a second.
NS = 10**9
#: More than the rounding of a time since the epoch as a float [ns].
ROUNDED_NS = 250
#: No time: what a message without a valid stamp has in place of one.
NO_TIME = -(1 << 62)
#: The largest time that counts as one [s]: 64 bits hold differences of these in nanoseconds.
LARGEST_S = 4.3e9
_ENDS = int(LARGEST_S) * NS


def to_ns(seconds: float) -> int:
    """Return a time in whole nanoseconds.

    :param seconds: the time [s]; infinity for the first or the last time that there is
    """
    if abs(seconds) >= LARGEST_S:
        return _ENDS if seconds > 0 else -_ENDS
    whole = math.floor(seconds)  # the rest alone keeps all digits that the number has
    return whole * NS + round((seconds - whole) * NS)


def to_seconds(nanoseconds: int) -> float:
    """Return a time in seconds, infinite where :func:`to_ns` has met infinity."""
    return nanoseconds / NS if abs(nanoseconds) < _ENDS else math.copysign(math.inf, nanoseconds)


def shifted(nanoseconds: int, by: int) -> int:
    """Return a time some nanoseconds later, infinite where it or the shift is."""
    for one in (nanoseconds, by):
        if abs(one) >= _ENDS:
            return _ENDS if one > 0 else -_ENDS
    return min(max(nanoseconds + by, -_ENDS), _ENDS)


def array_to_ns(seconds: numpy.ndarray) -> numpy.ndarray:
    """Return times in whole nanoseconds.

    :param seconds: the times [s]; those that are invalid, or too large, become :data:`NO_TIME`
    """
    valid = numpy.abs(seconds) <= LARGEST_S  # which NaN is not
    whole = numpy.floor(numpy.where(valid, seconds, 0.0))
    rest = numpy.rint((numpy.where(valid, seconds, 0.0) - whole) * NS)
    times = whole.astype(numpy.int64) * NS + rest.astype(numpy.int64)
    return numpy.where(valid, times, NO_TIME)


def exact_seconds(nanoseconds: int) -> str:
    """Return a time in s, without rounding it."""
    seconds, rest = divmod(abs(nanoseconds), NS)
    return f"{'-' if nanoseconds < 0 else ''}{seconds}.{rest:09}"
