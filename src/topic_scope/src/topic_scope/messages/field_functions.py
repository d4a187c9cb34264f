# Pure: knows no ROS.
"""Fixed list of functions of a field: derivative, difference, unwrap, yaw of a quaternion."""

import math
from typing import Callable, Dict, Sequence, Tuple

import numpy

from topic_scope.timing.nanoseconds import NS

#: Times [ns] and values.
Samples = Tuple[numpy.ndarray, numpy.ndarray]
#: Incremental computation of a trace: takes times [ns], a row for each number of a message
#: that is needed, and the longest time between connected samples [s]; returns times and values, for
#: all samples except perhaps the first.
Function = Callable[[numpy.ndarray, numpy.ndarray, float], Samples]

#: Names of the fields of a quaternion.
QUATERNION = ("x", "y", "z", "w")


def make(name: str) -> Function:
    """Return a function in its initial state.

    :param name: one of :data:`FUNCTIONS`, or empty for the identity
    """
    return _FUNCTIONS[name]() if name else _as_it_is


def parts(name: str) -> Sequence[Tuple[str, ...]]:
    """Return the parts of a field that a function needs, as suffixes of its path.

    :param name: as for :func:`make`
    """
    return [(part,) for part in QUATERNION] if name == "yaw" else [()]


def _as_it_is(times: numpy.ndarray, rows: numpy.ndarray, _longest: float) -> Samples:
    return times, rows[0]


def _yaw(times: numpy.ndarray, rows: numpy.ndarray, _longest: float) -> Samples:
    """Return the yaw of quaternions [rad], which need not be normalised."""
    x, y, z, w = rows
    turned: numpy.ndarray = numpy.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return times, numpy.where((rows == 0.0).all(axis=0), numpy.nan, turned)


class _Steps:
    """Difference or slope of each sample and the previous one.

    :param is_slope: whether to divide by the time between both; a slope is placed in the middle
    """

    def __init__(self, is_slope: bool) -> None:
        self._is_slope = is_slope
        self._last = numpy.empty(0, numpy.int64), numpy.empty(0)

    def __call__(self, times: numpy.ndarray, rows: numpy.ndarray, longest: float) -> Samples:
        at, values = (numpy.concatenate(both) for both in zip(self._last, (times, rows[0])))
        self._last = at[-1:], values[-1:]
        with numpy.errstate(all="ignore"):
            apart, steps = numpy.diff(at), numpy.diff(values)
            # A late sample, or the first after its clock was set back, has no valid step.
            steps[apart <= 0] = numpy.nan
            if not self._is_slope:
                return at[1:], steps
            steps[apart > longest * NS] = numpy.nan
            return at[1:] - numpy.maximum(apart, 0) // 2, steps / apart * NS


class _Unwrap:
    """Phase unwrapping of an angle [rad]."""

    def __init__(self) -> None:
        self._last = numpy.empty(0)
        self._turns = 0.0

    def __call__(self, times: numpy.ndarray, rows: numpy.ndarray, _longest: float) -> Samples:
        values = numpy.array(rows[0])
        finite = numpy.isfinite(values)
        angles = numpy.concatenate([self._last, values[finite]])
        if len(angles):
            jumps = numpy.round(numpy.diff(angles / (2.0 * math.pi)))
            turns = self._turns - numpy.concatenate([[0.0], numpy.cumsum(jumps)])
            values[finite] = (angles + 2.0 * math.pi * turns)[len(self._last) :]
            self._last, self._turns = angles[-1:], float(turns[-1])
        return times, values


#: Name of the function that shows a text, or a number with named values, as a state.
STATE = "state"
#: Name of the derivative per second.
DERIVATIVE = "derivative"
_FUNCTIONS: Dict[str, Callable[[], Function]] = {
    DERIVATIVE: lambda: _Steps(True),
    "difference": lambda: _Steps(False),
    "unwrap": _Unwrap,
    "yaw": lambda: _yaw,
    STATE: lambda: _as_it_is,
}
#: Names of the functions, written after the name of a field and a dot.
FUNCTIONS: Tuple[str, ...] = tuple(_FUNCTIONS)
