"""Frequency of a trace, and whether it is periodic at all.

A candidate for the period is the mean time between crossings of the mean, up to some times that, or
the strongest line of the spectrum. It is one if the trace repeats itself: samples in the same part
of different periods are alike. So does phase dispersion minimisation (Stellingwerf, 1978). The
statistic is half of the mean square of their differences over the variance: near 0 for what repeats
itself, and near 1 for noise. It needs neither even times nor a certain shape.
"""

import math
from typing import NamedTuple, Tuple

import numpy

from topic_scope.analysis.crossings import after_gaps, longest_stretch, rises
from topic_scope.analysis.measurement import Measurement, measured, unmeasurable
from topic_scope.analysis.spectrum import SURE, TOO_FEW, peaks, spectrum

#: A trace has to leave its mean by this part of its range before a crossing of the mean counts:
#: noise on it makes no periods.
HYSTERESIS = 0.1
#: A period may have up to so many crossings, if it repeats itself better by this factor then.
_MOST_CROSSINGS, _BETTER = 4, 0.2
#: So many parts of a period may be mixed, as those with the edges of a square wave.
_MIXED = 3.0
#: What repeats itself has less than this of the statistic: so much of its power is noise.
_NOISE = 0.4
#: Of less than so many periods, less than this: what is smooth looks like itself by chance.
_FEW, _CLEARLY = 3.0, 0.12
#: From so many crossings on, their own spread says how sure they are.
_SEVERAL = 6
#: Into how many parts a period is divided; so many samples are in each at least.
_PARTS, _LEAST = 40, 5
#: Most samples that are compared, and most of which there is a spectrum.
_COMPARED, _LATEST = 2000, 1 << 12
#: Mixed, so that not only each period and the next are compared, but any two.
_ORDER = numpy.random.RandomState(0).permutation(_COMPARED)
#: Crossings that are off even ones by this part of their distance are of no period.
_ASTRAY = 0.5

#: The drift is taken out in so many rounds, until the frequency moves by less than this part of its
#: uncertainty.
_ROUNDS, _ALIKE = 6, 0.1
#: What is left of noise is not that much alike from one sample to the next.
_ALIKE_REST = 0.5
#: That is looked at where a period has so many samples.
_DENSE = 8

STANDS = unmeasurable("it does not change")
TOO_SHORT = unmeasurable("fewer than two periods in the span")
DRIFTS = unmeasurable("its mean drifts too much")
NOT_ENOUGH = unmeasurable("not periodic enough: a part of it repeats itself otherwise")
NO_PERIOD = unmeasurable("not periodic: noise, or no steady frequency")


class _Comparison(NamedTuple):
    """Similarity of the periods of a trace.

    :param noise: the statistic: 0 for what repeats itself, 1 for noise
    :param limit: below this it is no noise, as far as so many samples can show
    :param mixed: below this it may be from edges
    :param cycles: how many periods there are
    """

    noise: float = 1.0
    limit: float = 0.0
    mixed: float = 0.0
    cycles: float = 0.0


_UNLIKE = _Comparison()


def frequency(
    times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf
) -> Measurement:
    """Measure how often a trace repeats itself in a second, on a mean that may drift.

    :param times: ascending [s]
    :param values: finite, and of moderate size
    :param longest: how far apart samples of one line may be [s]: no period is across a gap
    :returns: the frequency [Hz]
    """
    found = _frequency(times, values, longest)
    if found.value is None or len(after_gaps(times, longest)):
        return found
    since = times - times[0]
    for _ in range(_ROUNDS):
        assert found.value is not None
        slope, doubt = _slope_of_means(since, values, 1.0 / found.value)
        if abs(slope) <= doubt:
            break
        values = values - slope * since
        again = _frequency(times, values, longest)
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
    """Return how fast the mean over whole periods changes [1/s], and how far off that may be.

    :param since: times from the first sample on [s]
    """
    count = int(since[-1] / period)
    if count < 2:
        return 0.0, 0.0
    areas = numpy.concatenate([[0.0], numpy.cumsum(numpy.diff(since) * _middles(values))])
    means = numpy.diff(numpy.interp(period * numpy.arange(count + 1), since, areas)) / period
    at = numpy.arange(count) - (count - 1) / 2.0
    slope = float((at * means).sum() / numpy.square(at).sum()) / period
    rest = means - means.mean() - slope * period * at
    spread = math.sqrt(float(numpy.square(rest).sum()) / max(count - 2, 1))
    # A period ends between two samples, so its mean is off by some of the step between them.
    step = float(numpy.abs(numpy.diff(values)).max()) * count / len(values)
    noise = 3.0 * spread / (period * math.sqrt(float(numpy.square(at).sum())))
    return slope, noise + 3.0 * step / (count * period)


def _middles(values: numpy.ndarray) -> numpy.ndarray:
    return (values[1:] + values[:-1]) / 2.0


def _frequency(times: numpy.ndarray, values: numpy.ndarray, longest: float) -> Measurement:
    """Measure how often a trace repeats itself in a second, on a steady mean."""
    if len(values) < 3 or not values.min() < values.max():
        return STANDS
    firsts = after_gaps(times, longest)  # of the pieces without a gap, but for the very first
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
        # What has several crossings has to repeat itself much better than from one to the next.
        limit = found.limit if count == 1 else min(found.limit, _CLEARLY, _BETTER * noise)
        if period.value and found.noise < limit and (count == 1 or found.cycles > _FEW):
            best = measured(1.0 / period.value, period.uncertainty / period.value**2)
        elif count == 1:  # where crossings are missing, as of few samples, the spectrum knows more
            best = _strongest_line(times, values, longest)
        is_better = count > 1 and found.noise < limit
        noise = min(noise, found.noise)
        if best.value is not None and (noise < found.mixed or is_better):
            break
    if best.value is not None and noise > _CLEARLY and _has_more(times, values, best.value):
        return NOT_ENOUGH
    return best


def _has_more(times: numpy.ndarray, values: numpy.ndarray, hertz: float) -> bool:
    """Return whether what does not repeat itself is no noise, but goes on from sample to sample."""
    turns = (times - times[0]) * hertz
    if len(turns) < _DENSE * turns[-1]:
        return False  # neighbours tell nothing of what is between them
    parts = ((turns - numpy.floor(turns)) * _PARTS).astype(numpy.int64)
    counts = numpy.maximum(numpy.bincount(parts, minlength=_PARTS), 1)
    rest = values - (numpy.bincount(parts, values, _PARTS) / counts)[parts]
    return bool((rest[1:] * rest[:-1]).mean() > _ALIKE_REST * numpy.square(rest).mean())


def _some(count: int) -> numpy.ndarray:
    """Return which ones of so many samples are compared, mixed."""
    places = _ORDER * -(-count // _COMPARED)
    some: numpy.ndarray = places[places < count]
    return some


def _compared(places: numpy.ndarray, values: numpy.ndarray, period: float) -> _Comparison:
    """Compare the samples in the same parts of different periods.

    :param places: times of the samples since the begin of a period [s]; NaN where it is unknown
    :param values: the samples, mixed
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
    """Return where a trace crosses its mean upwards, or downwards, as :func:`.rises` does.

    The last row is how much of the doubt is from an edge [s].
    """
    low, high = values.min(), values.max()
    band = HYSTERESIS * (high - low)
    # Short pulses leave a mean that is close to where they come from on one side only.
    level = min(max(values.mean(), low + 2 * band), high - 2 * band)
    for sign in (1.0, -1.0):
        found, piece_of = rises(times, sign * values, sign * level, band, firsts)
        if (piece_of[:-1] == piece_of[1:]).any():
            break
        # Of two periods in a piece, one may begin too close to an end of it to be seen.
    found[2] /= high - low
    return found, piece_of


def _period(crossings: numpy.ndarray, piece_of: numpy.ndarray) -> Measurement:
    """Return the mean time from one crossing to the next one of the same piece [s].

    :param crossings: when, how far off that may be, and how much of that is from an edge [s]
    :param piece_of: which piece each is in
    """
    moments, doubts, edges = crossings
    length, weights = _slope(moments, piece_of)
    if not length > 0.0:  # the stamps of a simulation that stands are the same
        return TOO_SHORT
    doubt, drift = float(doubts.max()), 0.0
    if len(moments) >= _SEVERAL:
        rest = _within(moments - length * numpy.arange(len(moments)), piece_of)
        spread = math.sqrt(float(numpy.square(rest).sum()) / (len(moments) - 2))
        if spread > _ASTRAY * length:
            return NO_PERIOD
        # An edge may be anywhere between two samples, what is smooth is on a line between them.
        doubt = min(doubt, float(numpy.median(edges)) / 2.0 + 3.0 * spread)
        half = len(moments) // 2
        parts = [_slope(moments[one], piece_of[one])[0] for one in (slice(half), slice(half, None))]
        drift = abs(parts[1] - parts[0])
    return measured(length, doubt * float(numpy.abs(weights).sum()) + drift)


def _slope(moments: numpy.ndarray, piece_of: numpy.ndarray) -> Tuple[float, numpy.ndarray]:
    """Return the period that fits crossings best [s], and what weight each crossing has."""
    apart = _within(numpy.arange(float(len(moments))), piece_of)
    total = float(numpy.square(apart).sum())
    weights = apart / total if total else apart
    # From the first one on: of times since the epoch, sums would keep few digits.
    return float((weights * (moments - moments[:1])).sum()), weights


def _within(numbers: numpy.ndarray, piece_of: numpy.ndarray) -> numpy.ndarray:
    """Return numbers less the mean of those of the same piece."""
    if len(numbers) and piece_of[0] == piece_of[-1]:
        return numbers - numbers.mean()
    _, group = numpy.unique(piece_of, return_inverse=True)
    counts = numpy.bincount(group)
    less: numpy.ndarray = (numpy.bincount(group, numbers) / numpy.maximum(counts, 1))[group]
    return numbers - less


def _begins(moments: numpy.ndarray, piece_of: numpy.ndarray, count: int) -> numpy.ndarray:
    """Return the first crossing of each piece [s]; NaN for a piece without one."""
    begins = numpy.full(count, math.nan)
    begins[piece_of[::-1]] = moments[::-1]
    return begins


def _strongest_line(times: numpy.ndarray, values: numpy.ndarray, longest: float) -> Measurement:
    """Return the frequency of the strongest sine, if the trace repeats itself so often [Hz]."""
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
