"""Measurements of a step: a change from one steady level to another.

Times are those at which a level is reached by the samples, which are averaged over a short part of
the rise. With all that noise, averaging and the rest of the approach may have changed, a level is
reached between the times at which a somewhat lower and a somewhat higher one are: these two bound
the figure.
"""

import math
from typing import NamedTuple, Tuple, Union

import numpy

from topic_scope.analysis.measurement import Measurement, between, measured, unmeasurable

#: Between these parts of the way from one level to the other lies the rise time.
LOW, HIGH = 0.1, 0.9
#: A step has settled where it stays this near to where it ends, as a part of the step.
SETTLED = 0.02
#: So much of a step, its last part, says where it ends, and so many samples that it begins at rest.
_LAST, _REST = 0.05, 3
#: It rests at its end for this part of the time that it has taken to settle, at least.
_RESTS = 1.0
#: Its end may be further away than it still moves there, by this factor.
_APPROACH = 2.0
#: A step is so much higher than the noise, and this part of the whole range at least.
_ABOVE, _OF_RANGE = 10.0, 0.45
#: Samples are averaged over this part of the rise, if the noise is above this part of the step.
_AVERAGED, _LITTLE = 0.1, 1e-3
#: Values are rounded to counts where they have so many levels at least, which are so many of the
#: samples at most.
_LEVELS, _REPEATED = 4, 0.5
#: So many standard deviations are the most that noise adds to a value.
_SURELY = 3.5

NOISE = "the noise on it is too large"


class Step(NamedTuple):
    """A step that rises.

    :param times: ascending [s]
    :param values: samples, averaged, turned over if the step falls
    :param low: where it begins
    :param high: where it ends
    :param doubt: how far off values and levels may be
    :param spacing: how far off times may be: from one sample to the next, at least [s]
    """

    times: numpy.ndarray
    values: numpy.ndarray
    low: float
    high: float
    doubt: float
    spacing: float

    @property
    def height(self) -> float:
        return self.high - self.low


def step_of(times: numpy.ndarray, values: numpy.ndarray) -> Union[Step, str]:
    """Return the step of a trace, or the reason why it is not a step.

    :param times: ascending [s]
    :param values: finite, and of moderate size, not all the same
    """
    if len(values) < 4 * _REST or not times[0] < times[-1]:
        return "too few samples"
    low, high = _levels(values)
    values, height = (values, high - low) if low < high else (-values, low - high)
    sigma = _noise_of(values)
    mean_doubt = _SURELY * sigma / math.sqrt(_count(values))
    spacing = float(times[-1] - times[0]) / (len(times) - 1)
    width = _width(values, height) if _SURELY * sigma > _LITTLE * height else 1
    if width > 1:
        mean = numpy.full(width, 1.0 / width)
        times = times[0] + numpy.convolve(times - times[0], mean, "valid")
        values, sigma = numpy.convolve(values, mean, "valid"), sigma / math.sqrt(width)
        spacing *= 1.0 + width / 4.0  # corners are round now
    low, high = _levels(values)
    doubt = mean_doubt + _SURELY * sigma + count_of(values, height) / 2.0
    step = Step(times, values, low, high, doubt, spacing)
    return _why_none(step, sigma) or step._replace(doubt=step.doubt + _APPROACH * _moves(step))


def rise(step: Step) -> Measurement:
    """Return the time from 10 % to 90 % of the way from one level to the other [s]."""
    return rise_of(step.times, step.values, (step.low, step.high), step.doubt, step.spacing)


def overshoot(step: Step) -> Measurement:
    """Return how far it goes beyond where it ends, % of its height."""
    return overshoot_of(step.values, (step.low, step.high), step.doubt)


def settling(step: Step) -> Measurement:
    """Return the time from where it leaves its begin until it stays near its end [s]."""
    band = SETTLED * step.height
    # Between two samples it may be further away than at both.
    doubt = step.doubt + float(numpy.abs(numpy.diff(step.values[_left(step) :], 2)).max()) / 8.0
    if doubt >= band:
        return unmeasurable(NOISE)
    begins = [_first_away(step, band + more) for more in (-step.doubt, step.doubt)]
    ends = [_last_away(step, band + more) for more in (doubt, -doubt)]
    return between(ends[0] - begins[1], ends[1] - begins[0], step.spacing)


def rise_of(
    times: numpy.ndarray,
    values: numpy.ndarray,
    levels: Tuple[float, float],
    doubt: float,
    spacing: float,
) -> Measurement:
    """Return the time from 10 % to 90 % of the way between two levels [s].

    :param times: ascending [s]
    :param values: from the lower level to the upper one
    :param levels: the lower one and the upper one
    :param doubt: how far off values and levels may be
    :param spacing: how far off times may be [s]
    """
    low, height = levels[0], levels[1] - levels[0]
    if doubt >= LOW * height:
        return unmeasurable(NOISE)
    ends, starts = [], []
    for more in (-doubt, doubt):
        level = low + HIGH * height + more
        after = int(numpy.argmax(values >= level))
        if after == 0:
            return unmeasurable(NOISE)
        ends.append(_crossing(times, values, after, level))
    first = int(numpy.argmax(values >= low + HIGH * height - doubt))
    for more in (-doubt, doubt):
        level = low + LOW * height + more
        below = numpy.flatnonzero(values[:first] < level)
        if not len(below):
            return unmeasurable("the step begins before the span")
        starts.append(_crossing(times, values, int(below[-1]) + 1, level))
    found = between(ends[0] - starts[1], ends[1] - starts[0], spacing)
    if found.value is not None and found.uncertainty > max(found.value / 2.0, 2.0 * spacing):
        return unmeasurable(NOISE)
    return found


def overshoot_of(values: numpy.ndarray, levels: Tuple[float, float], doubt: float) -> Measurement:
    """Return how far values go beyond the upper of two levels, % of the way between them.

    :param values: with the highest ones
    :param levels: the lower one and the upper one
    :param doubt: how far off values and levels may be
    """
    height = levels[1] - levels[0]
    top = int(values.argmax())
    near = values[max(top - 1, 0) : top + 2]
    # The parabola through the top and its neighbours is so much higher at most.
    missed = abs(float(numpy.diff(near, 2).sum())) / 8.0 if len(near) == 3 else 0.0
    if doubt + missed > LOW * height:
        return unmeasurable(NOISE)
    return measured(
        100.0 * (float(values[top]) - levels[1]) / height,
        100.0 * (2.0 * doubt + missed) / height,
    )


def count_of(values: numpy.ndarray, height: float) -> float:
    """Return the distance of the levels that values are rounded to; 0 where they are not.

    :param values: the samples
    :param height: what of them is measured
    """
    levels = numpy.unique(values)
    if not _LEVELS <= len(levels) <= len(values) * _REPEATED:
        return 0.0  # two levels are those of a switch, which are exact
    count = float(numpy.diff(levels).min())
    return count if count > height * 1e-9 else 0.0


def _noise_of(values: numpy.ndarray) -> float:
    """Return the standard deviation of the noise on what is smooth from sample to sample."""
    # White noise has six times its variance in second differences; the median leaves edges out.
    return 1.4826 * float(numpy.median(numpy.abs(numpy.diff(values, 2)))) / math.sqrt(6.0)


def _width(values: numpy.ndarray, height: float) -> int:
    """Return over how many samples the mean may be taken: an odd number."""
    low = values[:_REST].mean()
    arrived = int(numpy.argmax(values >= low + HIGH * height))
    below = numpy.flatnonzero(values[:arrived] < low + LOW * height)
    rising = arrived - int(below[-1]) if len(below) else 0
    return max(int(_AVERAGED * rising) - 1, 0) // 2 * 2 + 1


def _levels(values: numpy.ndarray) -> Tuple[float, float]:
    """Return where it begins and where it ends."""
    high = float(values[-_count(values) :].mean())
    low = float(numpy.median(values[:_REST]))
    away = numpy.abs(values - low) > SETTLED * abs(high - low)
    rests = int(numpy.argmax(away))  # half of it, as the last samples may have left it
    return float(values[: max(rests // 2, _REST)].mean()), high


def _moves(step: Step) -> float:
    """Return how far it still moves while it rests at its end, beyond what noise does."""
    rests = step.times > (_last_away(step, SETTLED * step.height + step.doubt) + step.times[-1]) / 2
    furthest = numpy.abs(step.values[rests] - step.high).max(initial=0.0)
    return max(float(furthest) - step.doubt, 0.0)


def _count(values: numpy.ndarray) -> int:
    """Return how many samples say where it ends."""
    return max(math.ceil(_LAST * len(values)), _REST)


def _why_none(step: Step, sigma: float) -> str:
    """Return why a trace is not a step; an empty text for a step."""
    values, height = step.values, step.height
    if height <= _ABOVE * sigma or height < _OF_RANGE * float(values.max() - values.min()):
        return "it does not end at another level than it begins at"
    band = SETTLED * height + step.doubt
    if (numpy.abs(values[:_REST] - step.low) > band).any():
        return "the step begins before the span"
    arrived = int(numpy.argmax(values >= step.low + HIGH * height - step.doubt))
    if (values[arrived:] < step.low + LOW * height).any():
        return "it goes back to where it begins"
    begin, end = _first_away(step, band), _last_away(step, band)
    if float(step.times[-1]) - end < _RESTS * (end - begin):
        return "it does not rest at the end of the span for long enough"
    return ""


def _left(step: Step) -> int:
    """Return the first sample that is in the upper half."""
    return min(int(numpy.argmax(step.values >= step.low + step.height / 2.0)), len(step.values) - 3)


def _first_away(step: Step, band: float) -> float:
    """Return when it first gets so far away from its begin [s]."""
    away = int(numpy.argmax(numpy.abs(step.values - step.low) > band))
    side = math.copysign(band, step.values[away] - step.low)
    return _crossing(step.times, step.values, away, step.low + side)


def _last_away(step: Step, band: float) -> float:
    """Return when it is as far away from its end for the last time [s]."""
    away = int(numpy.flatnonzero(numpy.abs(step.values - step.high) > band)[-1])
    if away == len(step.values) - 1:
        return float(step.times[-1])
    side = math.copysign(band, step.values[away] - step.high)
    return _crossing(step.times, step.values, away + 1, step.high + side)


def _crossing(times: numpy.ndarray, values: numpy.ndarray, index: int, level: float) -> float:
    """Return when the line from the sample before to this one is at a level [s]."""
    if index == 0:
        return float(times[0])
    low, high = values[index - 1 : index + 1]
    part = (level - low) / (high - low)
    return float(times[index - 1] + part * (times[index] - times[index - 1]))
