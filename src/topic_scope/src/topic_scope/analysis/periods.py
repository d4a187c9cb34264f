"""Frequency of a trace, and the test whether it is periodic.

Candidates for the period are the mean time between crossings of the mean, its small multiples, and
the strongest line of the spectrum. A candidate is accepted if the trace repeats itself: samples at
the same phase of different periods are alike, as in phase dispersion minimisation (Stellingwerf,
1978). The statistic is half of the mean square of their differences over the variance: near 0 for a
periodic trace, near 1 for noise. It requires neither even sampling nor a particular shape.
"""

import math
from typing import NamedTuple, Tuple

import numpy

from topic_scope.analysis.crossings import after_gaps, longest_stretch, rises
from topic_scope.analysis.measurement import Measurement, measured, unmeasurable
from topic_scope.analysis.spectrum import SURE, TOO_FEW, peaks, spectrum

#: A crossing of the mean counts only after the trace has left the mean by this part of its range,
#: so that noise does not create periods.
HYSTERESIS = 0.1
#: Most crossings in a period; several are accepted only if the statistic improves by this factor.
_MOST_CROSSINGS, _BETTER = 4, 0.2
#: Parts of a period in which samples of different levels may mix, as at the edges of a square wave.
_MIXED = 3.0
#: Limit of the statistic for a periodic trace: the part of its power that may be noise.
_NOISE = 0.4
#: With fewer periods than this, the lower limit: a smooth trace resembles itself by chance.
_FEW, _CLEARLY = 3.0, 0.12
#: From this number of crossings on, the uncertainty is taken from their spread.
_SEVERAL = 6
#: Number of parts of a period, and the least number of samples in each.
_PARTS, _LEAST = 40, 5
#: Most samples that are compared, and most samples of a spectrum.
_COMPARED, _LATEST = 2000, 1 << 12
#: Shuffled, so that any two periods are compared, not only neighbours.
_ORDER = numpy.random.RandomState(0).permutation(_COMPARED)
#: Crossings that deviate from an even spacing by this part of it are not periodic.
_ASTRAY = 0.5

#: Most rounds of drift removal, which ends when the frequency changes by less than this part of its
#: uncertainty.
_ROUNDS, _ALIKE = 6, 0.1
#: Successive samples of residual noise correlate less than this.
_ALIKE_REST = 0.5
#: Least number of samples in a period for that test.
_DENSE = 8

STANDS = unmeasurable("the trace is constant")
TOO_SHORT = unmeasurable("fewer than two periods in the span")
DRIFTS = unmeasurable("the mean drifts too much")
NOT_ENOUGH = unmeasurable("not periodic: a part of the trace has another period")
NO_PERIOD = unmeasurable("not periodic: noise, or no steady frequency")


class _Comparison(NamedTuple):
    """Comparison of the periods of a trace.

    :param noise: the statistic: 0 for a periodic trace, 1 for noise
    :param limit: significance limit of the statistic for this number of samples
    :param mixed: value of the statistic that edges can explain
    :param cycles: number of periods
    """

    noise: float = 1.0
    limit: float = 0.0
    mixed: float = 0.0
    cycles: float = 0.0


_UNLIKE = _Comparison()


def frequency(
    times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf
) -> Measurement:
    """Measure the frequency of a trace whose mean may drift.

    :param times: ascending [s]
    :param values: finite, and of moderate size
    :param longest: longest time between connected samples [s]; no period spans a gap
    :returns: the frequency [Hz]
    """
    firsts = after_gaps(times, longest)  # starts of all gapless pieces except the first
    found = _frequency(times, values, firsts, longest)
    if found.value is None or len(firsts):
        return found
    since = times - times[0]
    for _ in range(_ROUNDS):
        assert found.value is not None
        slope, doubt = _slope_of_means(since, values, 1.0 / found.value)
        if abs(slope) <= doubt:
            break
        values = values - slope * since
        again = _frequency(times, values, firsts, longest)
        if again.value is None:
            return DRIFTS
        moved = abs(again.value - found.value)
        found = again
        if moved < _ALIKE * again.uncertainty:
            break
    else:
        return DRIFTS
    return found


def _slope_of_means(
    since: numpy.ndarray, values: numpy.ndarray, period: float
) -> Tuple[float, float]:
    """Return the slope of the mean over whole periods [1/s], and its uncertainty.

    :param since: times from the first sample on [s]
    """
    count = int(since[-1] / period)
    if count < 2:
        return 0.0, 0.0
    doubled = numpy.zeros(len(since))  # areas from the first sample on
    numpy.cumsum(numpy.diff(since) * (values[1:] + values[:-1]), out=doubled[1:])
    ends = period * numpy.arange(count + 1)
    means = numpy.diff(numpy.interp(ends, since, doubled)) / (2.0 * period)
    at = numpy.arange(count) - (count - 1) / 2.0
    slope = float((at * means).sum() / numpy.square(at).sum()) / period
    rest = means - means.mean() - slope * period * at
    spread = math.sqrt(float(numpy.square(rest).sum()) / max(count - 2, 1))
    # A period ends between two samples, which leaves an error in its mean.
    steps = numpy.diff(values)
    step = float(max(steps.max(), -steps.min())) * count / len(values)
    noise = 3.0 * spread / (period * math.sqrt(float(numpy.square(at).sum())))
    return slope, noise + 3.0 * step / (count * period)


def _frequency(
    times: numpy.ndarray, values: numpy.ndarray, firsts: numpy.ndarray, longest: float
) -> Measurement:
    """Measure the frequency of a trace with a steady mean."""
    if len(values) < 3 or not values.min() < values.max():
        return STANDS
    crossings, piece_of = _crossings(times, values, firsts)
    some = _some(len(times))
    best, noise = TOO_SHORT, 1.0
    for count in range(1, _MOST_CROSSINGS + 1):
        every = slice(None, None, count)
        period = _period(crossings[:, every], piece_of[every])
        if period == TOO_SHORT:
            break
        found = _UNLIKE
        if period.value is not None:
            begins = _begins(crossings[0, every], piece_of[every], len(firsts) + 1)
            begin = begins[numpy.searchsorted(firsts, some, "right")]
            found = _compared(times[some] - begin, values[some], period.value)
        # Several crossings in a period are accepted only if they fit much better than one.
        limit = found.limit if count == 1 else min(found.limit, _CLEARLY, _BETTER * noise)
        if period.value and found.noise < limit and (count == 1 or found.cycles > _FEW):
            best = measured(1.0 / period.value, period.uncertainty / period.value**2)
        elif count == 1:  # with few samples, crossings are missed; use the spectrum
            best = _strongest_line(times, values, longest)
        is_better = count > 1 and found.noise < limit
        noise = min(noise, found.noise)
        if best.value is not None and (noise < found.mixed or is_better):
            break
    if best.value is not None and noise > _CLEARLY and _has_more(times, values, best.value):
        return NOT_ENOUGH
    return best


def _has_more(times: numpy.ndarray, values: numpy.ndarray, hertz: float) -> bool:
    """Return whether the non-periodic rest is correlated between samples, hence not noise."""
    turns = (times - times[0]) * hertz
    if len(turns) < _DENSE * turns[-1]:
        return False  # too few samples in a period to compare neighbours
    parts = ((turns - numpy.floor(turns)) * _PARTS).astype(numpy.int64)
    counts = numpy.maximum(numpy.bincount(parts, minlength=_PARTS), 1)
    rest = values - (numpy.bincount(parts, values, _PARTS) / counts)[parts]
    return bool((rest[1:] * rest[:-1]).mean() > _ALIKE_REST * numpy.square(rest).mean())


def _some(count: int) -> numpy.ndarray:
    """Return the shuffled indices of the samples to compare."""
    places = _ORDER * -(-count // _COMPARED)
    some: numpy.ndarray = places[places < count]
    return some


def _compared(places: numpy.ndarray, values: numpy.ndarray, period: float) -> _Comparison:
    """Compare the samples at the same phase of different periods.

    :param places: times of the samples since the start of a period [s]; NaN if unknown
    :param values: the samples, shuffled
    :param period: length of the period [s]
    """
    turns = places / period
    known = numpy.isfinite(turns)
    turns, values = turns[known], values[known]
    if not len(turns) or not values.min() < values.max():
        return _UNLIKE
    cycles = numpy.floor(turns)
    count = min(_PARTS, 1 + len(turns) // _LEAST)
    parts = ((turns - cycles) * count).astype(numpy.int8)
    order = numpy.argsort(parts, kind="stable")
    compared = (numpy.diff(parts[order]) == 0) & (numpy.diff(cycles[order]) != 0.0)
    steps = numpy.diff(values[order])[compared]
    if not len(steps):
        return _UNLIKE
    limit = _NOISE - 2.0 / math.sqrt(len(steps))
    cycles_seen = float(turns.max() - turns.min())
    if cycles_seen < _FEW:
        limit = min(limit, _CLEARLY)
    noise = float(numpy.square(steps).mean() / values.var()) / 2.0
    return _Comparison(noise, limit, _MIXED / count, cycles_seen)


def _crossings(
    times: numpy.ndarray, values: numpy.ndarray, firsts: numpy.ndarray
) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return the upward or downward crossings of the mean, in the form of :func:`.rises`.

    The last row is the part of the uncertainty that edges cause [s].
    """
    low, high = values.min(), values.max()
    band = HYSTERESIS * (high - low)
    # Short pulses have their mean close to the base level, so only one side leaves it clearly.
    level = min(max(values.mean(), low + 2 * band), high - 2 * band)
    for sign in (1.0, -1.0):
        found, piece_of = rises(times, sign * values, sign * level, band, firsts)
        if (piece_of[:-1] == piece_of[1:]).any():
            break
        # With two periods in a piece, the start of one may be too close to its end to be seen.
    found[2] /= high - low
    return found, piece_of


def _period(crossings: numpy.ndarray, piece_of: numpy.ndarray) -> Measurement:
    """Return the mean time between successive crossings of the same piece [s].

    :param crossings: their times, uncertainties, and the part of those caused by edges [s]
    :param piece_of: index of the piece of each
    """
    moments, doubts, edges = crossings
    length, weights = _slope(moments, piece_of)
    if not length > 0.0:  # a paused simulation repeats its stamp
        return TOO_SHORT
    doubt, drift = float(doubts.max()), 0.0
    if len(moments) >= _SEVERAL:
        rest = _within(moments - length * numpy.arange(len(moments)), piece_of)
        spread = math.sqrt(float(numpy.square(rest).sum()) / (len(moments) - 2))
        if spread > _ASTRAY * length:
            return NO_PERIOD
        # An edge may be anywhere between two samples; a smooth trace is near the line between them.
        doubt = min(doubt, float(numpy.median(edges)) / 2.0 + 3.0 * spread)
        half = len(moments) // 2
        parts = [_slope(moments[one], piece_of[one])[0] for one in (slice(half), slice(half, None))]
        drift = abs(parts[1] - parts[0])
    return measured(length, doubt * float(numpy.abs(weights).sum()) + drift)


def _slope(moments: numpy.ndarray, piece_of: numpy.ndarray) -> Tuple[float, numpy.ndarray]:
    """Return the least-squares period of the crossings [s], and the weight of each."""
    apart = _within(numpy.arange(float(len(moments))), piece_of)
    total = float(numpy.square(apart).sum())
    weights = apart / total if total else apart
    # Relative to the first crossing: sums of epoch times would lose digits.
    return float((weights * (moments - moments[:1])).sum()), weights


def _within(numbers: numpy.ndarray, piece_of: numpy.ndarray) -> numpy.ndarray:
    """Return the numbers minus the mean of their piece."""
    if len(numbers) and piece_of[0] == piece_of[-1]:
        return numbers - numbers.mean()
    _, group = numpy.unique(piece_of, return_inverse=True)
    counts = numpy.bincount(group)
    less: numpy.ndarray = (numpy.bincount(group, numbers) / numpy.maximum(counts, 1))[group]
    return numbers - less


def _begins(moments: numpy.ndarray, piece_of: numpy.ndarray, count: int) -> numpy.ndarray:
    """Return the first crossing of each piece [s]; NaN for a piece without crossings."""
    begins = numpy.full(count, math.nan)
    begins[piece_of[::-1]] = moments[::-1]
    return begins


def _strongest_line(times: numpy.ndarray, values: numpy.ndarray, longest: float) -> Measurement:
    """Return the frequency of the strongest spectral line, if the trace has that period [Hz]."""
    part = longest_stretch(times, longest)
    times, values = times[part], values[part]
    lines = spectrum(times[-_LATEST:], values[-_LATEST:])
    strongest = peaks(lines, "hann", 1) if lines is not None else []
    if lines is None or not strongest or strongest[0].reason == TOO_FEW:
        return NO_PERIOD
    some = _some(len(times))
    found = _compared(times[some] - times[0], values[some], 1.0 / strongest[0].frequency)
    if found.noise >= found.limit:
        return NO_PERIOD
    return measured(strongest[0].frequency, SURE * lines.step)
