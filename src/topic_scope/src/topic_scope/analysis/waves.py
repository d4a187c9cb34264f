"""Measurements of a periodic wave, from all of its periods laid over one another.

Samples at one place of the period, each out of another period, are averaged: their noise goes, and
a slope is sampled as densely as all periods together sample it.
"""

import math
from typing import NamedTuple, Optional, Tuple

import numpy

from topic_scope.analysis.measurement import Measurement, between, measured, unmeasurable
from topic_scope.analysis.steps import NOISE, count_of, overshoot_of, rise_of

#: Samples are averaged over this part of a period at most.
_AVERAGED = 0.01
#: It rests at a level if half of the samples near it are within this part of the height.
_RESTS = 0.02
#: So many standard deviations are the most that noise adds to a value.
_SURELY = 3.5
#: A duty cycle is known to this part of a period, or not at all.
_SHARP = 0.1
#: Into how many parts a period is divided to find how long it is above a level.
_PARTS = 4096


class Wave(NamedTuple):
    """One period of a wave.

    :param times: since the begin of the period, ascending [s]
    :param values: means of the samples there
    :param period: its length [s]
    :param levels: the lower and the upper one
    :param rests: whether it rests at both
    :param doubt: how far off values and levels may be
    :param spacing: from one sample to the next one at most [s]
    :param drift: how far the last period may be from its place [s]
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
    """Lay all periods of a trace over one another.

    :param times: ascending [s], without a gap
    :param values: finite, and of moderate size
    :param frequency: how often it repeats itself [Hz]
    :returns: None where there is not one whole period
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
    # The samples stand so close together there, if the period is what it is said to be.
    spacing = float(numpy.diff(places, append=places[0] + period).max())
    width = max(int(min(cycles, _AVERAGED * len(values))), 1)
    if width > 1:
        places, values = _rounded(places, width, period), _rounded(values, width)
        sigma /= math.sqrt(width)
        spacing += width * period / len(values)  # corners are round now
    drift = frequency.uncertainty * length * period / 2.0
    doubt = _SURELY * sigma + count / 2.0
    low, low_rests = _level(-values, sigma)
    high, high_rests = _level(values, sigma)
    levels, rests = (-low, high), low_rests and high_rests
    return Wave(places, values, period, levels, rests, doubt, spacing, drift)


def rise(wave: Wave) -> Measurement:
    """Return the time from 10 % to 90 % of the way from one level to the other [s]."""
    low, high = wave.levels
    # From its lowest place on, through a whole period.
    start = int(wave.values.argmin())
    values = numpy.roll(wave.values, -start)
    times = numpy.roll(wave.times, -start)
    times[len(times) - start :] += wave.period
    return rise_of(times, values, (low, high), wave.doubt, wave.spacing + wave.drift)


def overshoot(wave: Wave) -> Measurement:
    """Return how far it goes beyond its upper level, % of the way between both."""
    if not wave.rests:
        return unmeasurable("no step: no two steady levels")
    return overshoot_of(wave.values, wave.levels, wave.doubt)


def duty(wave: Wave) -> Measurement:
    """Return the part of the time that it is above the middle of its levels, %."""
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
    """Return mean and RMS over whole periods, the latest ones.

    :param times: ascending [s], without a gap
    :param values: what the wave is made of
    :param wave: the wave
    :param frequency: how often it repeats itself [Hz]
    """
    assert frequency.value is not None
    whole = math.floor((times[-1] - times[0]) / wave.period + 1e-6) * wave.period
    begin = max(float(times[-1]) - whole, float(times[0]))
    inside = times > begin
    at = numpy.concatenate([[begin], times[inside]])
    there = numpy.concatenate([[numpy.interp(begin, times, values)], values[inside]])
    mean = _integral(at, there) / whole
    rms = math.sqrt(_integral(at, numpy.square(there)) / whole)
    # Edges may be anywhere between two samples; the rest is from ends that are not quite whole.
    step = float(numpy.diff(at).max())
    height = wave.levels[1] - wave.levels[0]
    sharp = min(float(numpy.abs(numpy.diff(there)).max()) / height, 1.0)
    ends = step / whole + frequency.uncertainty / frequency.value
    doubt = height * (sharp * step / wave.period + ends) + wave.doubt
    largest = float(numpy.abs(there).max())
    return measured(mean, doubt), measured(rms, doubt * largest / rms)


def _integral(times: numpy.ndarray, values: numpy.ndarray) -> float:
    """Return the integral of the lines between samples."""
    return float((numpy.diff(times) * (values[1:] + values[:-1])).sum()) / 2.0


def _rounded(values: numpy.ndarray, width: int, turn: float = 0.0) -> numpy.ndarray:
    """Return the means of so many neighbours, all around the period.

    :param turn: how much larger they are in the next period
    """
    before, after = width // 2, width - 1 - width // 2
    around = numpy.concatenate(
        [values[len(values) - before :] - turn, values, values[:after] + turn]
    )
    return numpy.convolve(around, numpy.full(width, 1.0 / width), "valid")


def _level(values: numpy.ndarray, sigma: float) -> Tuple[float, bool]:
    """Return the upper level of a wave, and whether it rests there.

    It is where most of the upper half is, or else the upper end.
    """
    low, high = float(values.min()), float(values.max())
    upper = values[values > (low + high) / 2.0]
    first, middle, last = numpy.percentile(upper, (25.0, 50.0, 75.0))
    rests = last - first <= _RESTS * (high - low) + 2.0 * sigma
    return (float(middle), True) if rests else (high, False)
