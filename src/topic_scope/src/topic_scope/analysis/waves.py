"""Rise time, overshoot, duty cycle, mean and RMS of a periodic wave, from its averaged period.

Samples at the same phase of different periods are averaged: this reduces noise, and samples a slope
as densely as all periods together.
"""

import math
from typing import NamedTuple, Optional, Tuple

import numpy

from topic_scope.analysis.measurement import Measurement, between, measured, unmeasurable
from topic_scope.analysis.steps import NOISE, count_of, overshoot_of, rise_of

#: Longest averaging time, as a fraction of a period.
_AVERAGED = 0.01
#: The wave rests at a level if half of the samples near it are within this fraction of the height.
_RESTS = 0.02
#: Largest contribution of noise to a value, in standard deviations.
_SURELY = 3.5
#: Largest uncertainty of a duty cycle, as a fraction of a period; otherwise it is not measured.
_SHARP = 0.1
#: Number of parts of a period for the time above a level.
_PARTS = 4096


class Wave(NamedTuple):
    """Average period of a wave.

    :param times: since the start of the period, ascending [s]
    :param values: means of the samples there
    :param period: its length [s]
    :param levels: lower and upper level
    :param rests: whether the wave rests at both
    :param doubt: uncertainty of values and levels
    :param spacing: largest sampling interval [s]
    :param drift: uncertainty of the position of a period, relative to the middle one [s]
    """

    times: numpy.ndarray
    values: numpy.ndarray
    period: float
    levels: Tuple[float, float]
    rests: bool
    doubt: float
    spacing: float
    drift: float


def wave_of(times: numpy.ndarray, values: numpy.ndarray, frequency: Measurement) -> Optional[Wave]:
    """Superpose all periods of a trace.

    :param times: ascending [s], without a gap
    :param values: finite and of moderate size
    :param frequency: of the wave [Hz]
    :returns: None if there is no whole period
    """
    assert frequency.value is not None
    length = float(times[-1] - times[0])
    cycles = length * frequency.value
    if cycles < 1.0 or len(times) < 8:
        return None
    period = 1.0 / frequency.value
    places = numpy.mod(times - times[0], period)
    order = places.argsort(kind="stable")
    places, values = places[order], values[order]
    count = count_of(values, float(values.max() - values.min()))
    sigma = 1.4826 * float(numpy.median(numpy.abs(numpy.diff(values)))) / math.sqrt(2.0)
    # Spacing of the superposed samples, if the period is exact.
    spacing = float(numpy.diff(places, append=places[0] + period).max())
    width = max(int(min(cycles, _AVERAGED * len(values))), 1)
    if width > 1:
        places, values = _rounded(places, width, period), _rounded(values, width)
        sigma /= math.sqrt(width)
        spacing += width * period / len(values)  # averaging rounds the corners
    drift = frequency.uncertainty * length * period / 2.0
    doubt = _SURELY * sigma + count / 2.0
    low, low_rests = _level(-values, sigma)
    high, high_rests = _level(values, sigma)
    levels, rests = (-low, high), low_rests and high_rests
    return Wave(places, values, period, levels, rests, doubt, spacing, drift)


def rise(wave: Wave) -> Measurement:
    """Return the rise time from 10 % to 90 % between the levels [s]."""
    low, high = wave.levels
    # Start at the lowest sample, for a whole period.
    start = int(wave.values.argmin())
    values = numpy.roll(wave.values, -start)
    times = numpy.roll(wave.times, -start)
    times[len(times) - start :] += wave.period
    # A wrong frequency spreads the edges of all periods over twice the drift.
    return rise_of(times, values, (low, high), wave.doubt, wave.spacing + 2.0 * wave.drift)


def overshoot(wave: Wave) -> Measurement:
    """Return the overshoot beyond the upper level, % of the distance of the levels."""
    if not wave.rests:
        return unmeasurable("no step: no two steady levels")
    return overshoot_of(wave.values, wave.levels, wave.doubt)


def duty(wave: Wave) -> Measurement:
    """Return the duty cycle: the time above the middle of the levels, %."""
    low, high = wave.levels
    if wave.doubt >= (high - low) / 4.0:
        return unmeasurable(NOISE)
    places = numpy.arange(_PARTS) / _PARTS * wave.period
    values = numpy.interp(places, wave.times, wave.values, period=wave.period)
    parts = [
        float((values > low + (high - low) / 2.0 + more).mean())
        for more in (wave.doubt, -wave.doubt)
    ]
    aside = (wave.spacing + wave.drift) / wave.period
    if aside > _SHARP:
        return unmeasurable("too few samples in a period")
    return between(100.0 * parts[0], 100.0 * parts[1], 100.0 * aside)


def cycle_figures(
    times: numpy.ndarray, values: numpy.ndarray, wave: Wave, frequency: Measurement
) -> Tuple[Measurement, Measurement]:
    """Return mean and RMS over the latest whole periods.

    :param times: ascending [s], without a gap
    :param values: the samples of the wave
    :param wave: the wave
    :param frequency: of the wave [Hz]
    """
    assert frequency.value is not None
    whole = math.floor((times[-1] - times[0]) / wave.period + 1e-6) * wave.period
    begin = max(float(times[-1]) - whole, float(times[0]))
    inside = times > begin
    at = numpy.concatenate([[begin], times[inside]])
    there = numpy.concatenate([[numpy.interp(begin, times, values)], values[inside]])
    mean = _integral(at, there) / whole
    rms = math.sqrt(_integral(at, numpy.square(there)) / whole)
    # Edges may be anywhere between two samples; the rest is from inexact ends of the periods.
    step = float(numpy.diff(at).max())
    height = wave.levels[1] - wave.levels[0]
    sharp = min(float(numpy.abs(numpy.diff(there)).max()) / height, 1.0)
    ends = step / whole + frequency.uncertainty / frequency.value
    doubt = height * (sharp * step / wave.period + ends) + wave.doubt
    largest = float(numpy.abs(there).max())
    return measured(mean, doubt), measured(rms, doubt * largest / rms)


def _integral(times: numpy.ndarray, values: numpy.ndarray) -> float:
    """Return the trapezoidal integral of samples."""
    return float((numpy.diff(times) * (values[1:] + values[:-1])).sum()) / 2.0


def _rounded(values: numpy.ndarray, width: int, turn: float = 0.0) -> numpy.ndarray:
    """Return the moving average of samples, periodic at its ends.

    :param turn: difference between one period and the next
    """
    before, after = width // 2, width - 1 - width // 2
    around = numpy.concatenate(
        [values[len(values) - before :] - turn, values, values[:after] + turn]
    )
    return numpy.convolve(around, numpy.full(width, 1.0 / width), "valid")


def _level(values: numpy.ndarray, sigma: float) -> Tuple[float, bool]:
    """Return the upper level of a wave, and whether the wave rests there.

    The level is the median of the upper half if the wave rests there, or else the maximum.
    """
    low, high = float(values.min()), float(values.max())
    upper = values[values > (low + high) / 2.0]
    first, middle, last = numpy.percentile(upper, (25.0, 50.0, 75.0))
    rests = last - first <= _RESTS * (high - low) + 2.0 * sigma
    return (float(middle), True) if rests else (high, False)
