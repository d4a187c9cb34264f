"""Measurements of a step: a change from one steady level to another.

The time of a level is the time at which the samples, averaged over a short part of the rise, reach
it. Noise, averaging and the final approach change the values by at most a known amount, so the time
lies between the times at which a slightly lower and a slightly higher level are reached: these two
bound the result.
"""

import math
from typing import NamedTuple, Tuple, Union

import numpy

from topic_scope.analysis.measurement import Measurement, between, measured, unmeasurable

#: The rise time is measured between these fractions of the step.
LOW, HIGH = 0.1, 0.9
#: Settling band around the final level, as a fraction of the step.
SETTLED = 0.02
#: Last fraction of a step that defines its final level; number of samples for its initial level.
_LAST, _REST = 0.05, 3
#: Least time at rest after settling, as a fraction of the settling time.
_RESTS = 1.0
#: The final level may be off by this multiple of the remaining movement.
_APPROACH = 2.0
#: Least height of a step: this multiple of the noise, and this fraction of the whole range.
_ABOVE, _OF_RANGE = 10.0, 0.45
#: Averaging time as a fraction of the rise; used if the noise exceeds this fraction of the step.
_AVERAGED, _LITTLE = 0.1, 1e-3
#: Values count as quantised if they have at least this many levels, which are at most this fraction
#: of the number of samples.
_LEVELS, _REPEATED = 4, 0.5
#: Largest contribution of noise to a value, in standard deviations.
_SURELY = 3.5

NOISE = "too much noise"


class Step(NamedTuple):
    """Rising step.

    :param times: ascending [s]
    :param values: averaged samples, inverted if the step falls
    :param low: initial level
    :param high: final level
    :param doubt: uncertainty of values and levels
    :param spacing: uncertainty of times, at least the sampling interval [s]
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
        spacing *= 1.0 + width / 4.0  # averaging rounds the corners
    low, high = _levels(values)
    doubt = mean_doubt + _SURELY * sigma + count_of(values, height) / 2.0
    step = Step(times, values, low, high, doubt, spacing)
    return _why_none(step, sigma) or step._replace(doubt=step.doubt + _APPROACH * _moves(step))


def rise(step: Step) -> Measurement:
    """Return the rise time from 10 % to 90 % of the step [s]."""
    return rise_of(step.times, step.values, (step.low, step.high), step.doubt, step.spacing)


def overshoot(step: Step) -> Measurement:
    """Return the overshoot beyond the final level, % of the height."""
    return overshoot_of(step.values, (step.low, step.high), step.doubt)


def settling(step: Step) -> Measurement:
    """Return the settling time, from leaving the initial level [s]."""
    band = SETTLED * step.height
    # Between two samples the deviation may be larger than at both.
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
    """Return the rise time from 10 % to 90 % between two levels [s].

    :param times: ascending [s]
    :param values: from the lower level to the upper level
    :param levels: lower and upper level
    :param doubt: uncertainty of values and levels
    :param spacing: uncertainty of times [s]
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
    """Return the overshoot beyond the upper level, % of the distance of the levels.

    :param values: including the highest
    :param levels: lower and upper level
    :param doubt: uncertainty of values and levels
    """
    height = levels[1] - levels[0]
    top = int(values.argmax())
    near = values[max(top - 1, 0) : top + 2]
    # Upper bound of the parabola through the top and its neighbours.
    missed = abs(float(numpy.diff(near, 2).sum())) / 8.0 if len(near) == 3 else 0.0
    if doubt + missed > LOW * height:
        return unmeasurable(NOISE)
    return measured(
        100.0 * (float(values[top]) - levels[1]) / height,
        100.0 * (2.0 * doubt + missed) / height,
    )


def count_of(values: numpy.ndarray, height: float) -> float:
    """Return the quantisation step of values; 0 if they are not quantised.

    :param values: the samples
    :param height: height of the step that is measured
    """
    levels = numpy.unique(values)
    if not _LEVELS <= len(levels) <= len(values) * _REPEATED:
        return 0.0  # two levels are those of a switch, which are exact
    count = float(numpy.diff(levels).min())
    return count if count > height * 1e-9 else 0.0


def _noise_of(values: numpy.ndarray) -> float:
    """Return the standard deviation of the noise on a smooth trace."""
    # Second differences have six times the variance of white noise; the median ignores edges.
    return 1.4826 * float(numpy.median(numpy.abs(numpy.diff(values, 2)))) / math.sqrt(6.0)


def _width(values: numpy.ndarray, height: float) -> int:
    """Return the averaging width in samples, an odd number."""
    low = values[:_REST].mean()
    arrived = int(numpy.argmax(values >= low + HIGH * height))
    below = numpy.flatnonzero(values[:arrived] < low + LOW * height)
    rising = arrived - int(below[-1]) if len(below) else 0
    return max(int(_AVERAGED * rising) - 1, 0) // 2 * 2 + 1


def _levels(values: numpy.ndarray) -> Tuple[float, float]:
    """Return initial and final level."""
    high = float(values[-_count(values) :].mean())
    low = float(numpy.median(values[:_REST]))
    away = numpy.abs(values - low) > SETTLED * abs(high - low)
    rests = int(numpy.argmax(away))  # use half of the rest: its last samples may have left it
    return float(values[: max(rests // 2, _REST)].mean()), high


def _moves(step: Step) -> float:
    """Return the remaining movement at the final level, beyond the noise."""
    rests = step.times > (_last_away(step, SETTLED * step.height + step.doubt) + step.times[-1]) / 2
    furthest = numpy.abs(step.values[rests] - step.high).max(initial=0.0)
    return max(float(furthest) - step.doubt, 0.0)


def _count(values: numpy.ndarray) -> int:
    """Return the number of samples that define the final level."""
    return max(math.ceil(_LAST * len(values)), _REST)


def _why_none(step: Step, sigma: float) -> str:
    """Return why a trace is not a step; an empty string for a step."""
    values, height = step.values, step.height
    if height <= _ABOVE * sigma or height < _OF_RANGE * float(values.max() - values.min()):
        return "initial and final level are equal"
    band = SETTLED * height + step.doubt
    if (numpy.abs(values[:_REST] - step.low) > band).any():
        return "the step begins before the span"
    arrived = int(numpy.argmax(values >= step.low + HIGH * height - step.doubt))
    if (values[arrived:] < step.low + LOW * height).any():
        return "the trace returns to its initial level"
    begin, end = _first_away(step, band), _last_away(step, band)
    if float(step.times[-1]) - end < _RESTS * (end - begin):
        return "the final level is not held for long enough"
    return ""


def _left(step: Step) -> int:
    """Return the index of the first sample in the upper half."""
    return min(int(numpy.argmax(step.values >= step.low + step.height / 2.0)), len(step.values) - 3)


def _first_away(step: Step, band: float) -> float:
    """Return the time at which the trace first leaves a band around its initial level [s]."""
    away = int(numpy.argmax(numpy.abs(step.values - step.low) > band))
    side = math.copysign(band, step.values[away] - step.low)
    return _crossing(step.times, step.values, away, step.low + side)


def _last_away(step: Step, band: float) -> float:
    """Return the time at which the trace last enters a band around its final level [s]."""
    away = int(numpy.flatnonzero(numpy.abs(step.values - step.high) > band)[-1])
    if away == len(step.values) - 1:
        return float(step.times[-1])
    side = math.copysign(band, step.values[away] - step.high)
    return _crossing(step.times, step.values, away + 1, step.high + side)


def _crossing(times: numpy.ndarray, values: numpy.ndarray, index: int, level: float) -> float:
    """Return the time at which the line from the previous sample crosses a level [s]."""
    if index == 0:
        return float(times[0])
    low, high = values[index - 1 : index + 1]
    part = (level - low) / (high - low)
    return float(times[index - 1] + part * (times[index] - times[index - 1]))
