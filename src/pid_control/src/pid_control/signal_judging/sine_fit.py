"""Least-squares fit of a sine with an offset."""

import math
from typing import NamedTuple, Optional, Sequence

import numpy
import scipy.optimize

#: Fewest samples of a fit, and fewest periods in its time.
_FEWEST, _LEAST_PERIODS = 8, 0.8
#: Frequencies tried per period of the whole time, and the highest one as a share of half the
#: sampling rate.
_PER_PERIOD, _HIGHEST = 8, 0.98
#: Number of frequencies that are tried together: bounds the memory.
_CHUNK = 256
#: Spread of values that are all the same, relative to their magnitude.
_CONSTANT = 1e-6


class SineFit(NamedTuple):
    """The sine offset + amplitude sin(frequency t + phase).

    :ivar amplitude: above 0
    :ivar frequency: angular [rad/s]
    :ivar phase: at t = 0, from -pi to pi [rad]
    :ivar offset: mean
    :ivar distortion: RMS of the residual, as a share of the amplitude
    :ivar periods: number of periods in the time of the samples
    """

    amplitude: float
    frequency: float
    phase: float
    offset: float
    distortion: float
    periods: float

    def at(self, time: float) -> float:
        """Return the value at a time [s]."""
        return self.offset + self.amplitude * math.sin(self.frequency * time + self.phase)


def wrapped(angle: float) -> float:
    """Return an angle from -pi to pi [rad]."""
    return math.remainder(angle, 2.0 * math.pi)


def is_constant(values: Sequence[float]) -> bool:
    """Return True if values do not differ by more than rounding."""
    low, high = min(values), max(values)
    return high - low <= _CONSTANT * max(abs(low), abs(high), _CONSTANT)


def fit_sine(
    times: Sequence[float], values: Sequence[float], frequency: Optional[float] = None
) -> Optional[SineFit]:
    """Fit a sine.

    :param times: ascending; several samples may have the same time [s]
    :param values: finite value at each time
    :param frequency: angular frequency, if known [rad/s]
    :returns: the sine; None for values that are constant, too few, or less than 0.8 periods
    """
    t, y = numpy.asarray(times, float), numpy.asarray(values, float)
    if len(t) < _FEWEST or is_constant(values) or t[-1] <= t[0]:
        return None
    if frequency is None:
        frequency = _best_frequency(t, y)
        if frequency is None:
            return None
    return _fit_at(t, y, frequency)


def _best_frequency(t: numpy.ndarray, y: numpy.ndarray) -> Optional[float]:
    span = float(t[-1] - t[0])
    steps = numpy.diff(t)
    steps = steps[steps > 0.0]
    step = 2.0 * math.pi / (_PER_PERIOD * span)
    lowest, highest = 2.0 * math.pi * _LEAST_PERIODS / span, math.pi / float(numpy.median(steps))
    grid = numpy.arange(lowest, _HIGHEST * highest, step)
    if len(grid) == 0:
        return None
    explained = numpy.concatenate(
        [_explained(t, y, grid[begin : begin + _CHUNK]) for begin in range(0, len(grid), _CHUNK)]
    )
    best = float(grid[int(numpy.argmax(explained))])
    found = scipy.optimize.minimize_scalar(
        lambda w: -float(_explained(t, y, numpy.array([w]))[0]),
        bounds=(max(best - step, 0.5 * lowest), best + step),
        method="bounded",
        options={"xatol": 1e-9 * best},
    )
    return float(found.x)


def _explained(t: numpy.ndarray, y: numpy.ndarray, grid: numpy.ndarray) -> numpy.ndarray:
    """Return the sum of squares that a sine and an offset explain, at each frequency."""
    phase = numpy.outer(grid, t - t[0])
    columns = numpy.stack([numpy.sin(phase), numpy.cos(phase), numpy.ones_like(phase)], axis=2)
    normal = numpy.einsum("wti,wtj->wij", columns, columns)
    normal += 1e-9 * len(t) * numpy.eye(3)  # near half the sampling rate, one column vanishes
    right = numpy.einsum("wti,t->wi", columns, y - y.mean())
    solution = numpy.linalg.solve(normal, right[:, :, None])[:, :, 0]
    explained: numpy.ndarray = (solution * right).sum(axis=1)
    return explained


def _fit_at(t: numpy.ndarray, y: numpy.ndarray, frequency: float) -> Optional[SineFit]:
    phase = frequency * t
    columns = numpy.column_stack([numpy.sin(phase), numpy.cos(phase), numpy.ones_like(t)])
    (sine, cosine, offset), *_ = numpy.linalg.lstsq(columns, y, rcond=None)
    amplitude = math.hypot(sine, cosine)
    if amplitude == 0.0:
        return None
    residual = y - columns @ numpy.array([sine, cosine, offset])
    return SineFit(
        amplitude,
        frequency,
        math.atan2(cosine, sine),
        float(offset),
        float(numpy.sqrt(numpy.mean(residual**2))) / amplitude,
        frequency * float(t[-1] - t[0]) / (2.0 * math.pi),
    )
