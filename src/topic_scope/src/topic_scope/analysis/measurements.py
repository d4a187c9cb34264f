"""What an engineer measures of a step and of a wave: times and ratios.

A trace that repeats itself is a wave. It has two levels: those at which it is most often, in the
lower and in the upper half of its range, or the ends of its range where it stays nowhere. Any other
trace is a step from its first value to the mean of its last ones.
"""

import math
from typing import Callable, Dict, NamedTuple, Optional

import numpy

from topic_scope.analysis.ring import Samples
from topic_scope.analysis.statistics import HYSTERESIS, edges, frequency, longest_stretch

#: Between these parts of the way from one level to the other lies the rise time.
LOW, HIGH = 0.1, 0.9
#: A step has settled where it stays this near to where it ends, as a part of the step.
SETTLED = 0.02
#: So much of a step, its last part, says where it ends.
_LAST = 0.05
#: Into how many parts a range is divided to find where a wave is most often.
_PARTS = 100
#: It stays where it is this part of the time, of that in one half of its range: a sine does not.
_STAYS = 0.2


class _Shape(NamedTuple):
    """A trace, and what has been found out of it.

    :param times: ascending, s
    :param values: finite; those of a step that falls are turned over, so that it rises
    :param low: the lower level, or the one that a step begins at
    :param high: the other level
    :param is_wave: whether it repeats itself
    """

    times: numpy.ndarray
    values: numpy.ndarray
    low: float
    high: float
    is_wave: bool

    @property
    def height(self) -> float:
        return self.high - self.low

    def at(self, part: float) -> float:
        """Return the value at a part of the way from the lower level to the upper one."""
        return self.low + part * self.height


def figures(
    times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf
) -> Dict[str, Optional[float]]:
    """Measure a step or a wave, in the longest stretch that has no gap.

    :param times: ascending, s
    :param values: the samples; what is not finite is left out
    :param longest: a gap is longer than this, s
    :returns: rise time (rise) and settling time (settling) in s, overshoot and duty in %; None for
        what there is not
    """
    times, values = _finite_of(times, values)
    part = longest_stretch(times, longest)
    shape = _shape(times[part], values[part])
    return {name: _finite(figure(shape)) if shape else None for name, figure in _FIGURES.items()}


def phase(samples: Samples, reference: Samples, longest: float = math.inf) -> Optional[float]:
    """Return how far a trace is ahead of another one, at the frequency of that.

    :param samples: times in s, ascending, and values of the trace
    :param reference: those of the other one
    :param longest: how far apart samples of one line of the other one may be, s
    :returns: above -180 and up to 180, degrees; None where the other one has no frequency
    """
    (times, values), (others, turns) = _finite_of(*samples), _finite_of(*reference)
    if len(times) < 3 or len(others) < 3:
        return None
    hertz = frequency(others, turns, longest)
    if hertz is None or not values.min() < values.max():
        return None
    # Both from the same moment on, and over whole periods: what is left of one would add to it.
    begin, end = max(times[0], others[0]), min(times[-1], others[-1])
    end = begin + math.floor((end - begin) * hertz + 1e-6) / hertz
    angles = [_angle(*part, hertz, begin, end) for part in ((times, values), (others, turns))]
    if angles[0] is None or angles[1] is None:
        return None
    return _finite(180.0 - (180.0 - math.degrees(angles[0] - angles[1])) % 360.0)


def _angle(
    times: numpy.ndarray, values: numpy.ndarray, hertz: float, begin: float, end: float
) -> Optional[float]:
    """Return the angle of the sine that fits a trace best, rad."""
    inside = (times >= begin) & (times <= end)
    turns = 2.0 * math.pi * hertz * (times[inside] - begin)
    parts = values[inside]
    if len(parts) < 3 or not parts.min() < parts.max():
        return None
    parts = (parts - parts.mean()) / (parts.max() - parts.min())
    columns = numpy.array([numpy.cos(turns), numpy.sin(turns), numpy.ones(len(turns))])
    try:
        cosine, sine, _ = numpy.linalg.solve(columns @ columns.T, columns @ parts)
    except numpy.linalg.LinAlgError:
        return None
    return math.atan2(cosine, sine)


def _finite_of(times: numpy.ndarray, values: numpy.ndarray) -> Samples:
    """Return the finite samples, from -1 to 1, so that no difference and no sum overflows."""
    finite = numpy.isfinite(values)
    times, values = times[finite], values[finite]
    largest = numpy.abs(values).max(initial=0.0)
    return times, values / largest if largest else values


def _shape(times: numpy.ndarray, values: numpy.ndarray) -> Optional[_Shape]:
    if len(values) < 2 or not values.min() < values.max():
        return None
    if frequency(times, values) is not None:
        middle = (values.min() + values.max()) / 2
        low = -_level(-values[values <= middle])
        high = _level(values[values > middle])
        return _Shape(times, values, low, high, True)
    low, high = float(values[0]), float(values[-math.ceil(_LAST * len(values)) :].mean())
    if high < low:
        values, low, high = -values, -low, -high
    return _Shape(times, values, low, high, False) if low < high else None


def _level(values: numpy.ndarray) -> float:
    """Return the upper level of a wave, from what is in the upper half of its range."""
    low, high = values.min(), values.max()
    if not low < high:
        return float(low)
    parts = numpy.minimum((values - low) / (high - low) * _PARTS, _PARTS - 1).astype(numpy.int64)
    counts = numpy.bincount(parts)
    most = counts.argmax()
    return float(values[parts == most].mean() if counts[most] > _STAYS * len(values) else high)


def _rise(shape: _Shape) -> Optional[float]:
    starts, _ = edges(shape.times, shape.values, shape.at(LOW), 0.0)
    ends, _ = edges(shape.times, shape.values, shape.at(HIGH), 0.0)
    if not len(starts) or not len(ends):
        return None
    # Each rise ends at the first arrival above, after the last start below.
    start_of = numpy.searchsorted(starts, ends, "right") - 1
    used, first = numpy.unique(start_of, return_index=True)
    first = first[used >= 0]
    times = ends[first] - starts[start_of[first]]
    if not len(times):
        return None
    return float(numpy.median(times) if shape.is_wave else times[0])


def _overshoot(shape: _Shape) -> Optional[float]:
    return 100.0 * (float(shape.values.max()) - shape.high) / shape.height


def _settling(shape: _Shape) -> Optional[float]:
    if shape.is_wave:
        return None
    band = SETTLED * shape.height
    left = numpy.flatnonzero(numpy.abs(shape.values - shape.low) > band)[0]
    away = numpy.flatnonzero(numpy.abs(shape.values - shape.high) > band)[-1]
    if away == len(shape.values) - 1:
        return None
    begin = _between(shape, left - 1, shape.low, band * numpy.sign(shape.values[left] - shape.low))
    end = _between(shape, away, shape.high, band * numpy.sign(shape.values[away] - shape.high))
    return end - begin


def _between(shape: _Shape, index: int, level: float, beyond: float) -> float:
    """Return when the line from a sample to the next one is so far beyond a level, s."""
    low, high = shape.values[index : index + 2]
    start, end = shape.times[index : index + 2]
    return float(start + (level + beyond - low) / (high - low) * (end - start))


def _duty(shape: _Shape) -> Optional[float]:
    if not shape.is_wave:
        return None
    band = HYSTERESIS * shape.height
    ups, downs = edges(shape.times, shape.values, shape.at(0.5), band)
    if not len(ups) or ups[-1] <= ups[0]:
        return None
    downs = downs[downs >= ups[0]][: len(ups) - 1]
    return 100.0 * float((downs - ups[:-1]).sum() / (ups[-1] - ups[0]))


_FIGURES: Dict[str, Callable[[_Shape], Optional[float]]] = {
    "rise": _rise,
    "overshoot": _overshoot,
    "settling": _settling,
    "duty": _duty,
}


def _finite(number: Optional[float]) -> Optional[float]:
    return number if number is not None and math.isfinite(number) else None
