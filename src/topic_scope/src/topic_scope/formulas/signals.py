"""Samples with what is needed to compute with them, and the functions of samples and times."""

import math
from typing import NamedTuple

import numpy

from topic_scope.analysis.xy import paired
from topic_scope.timing.nanoseconds import NS

#: After so many time constants a low-pass has forgotten what was before: to 2e-9.
SETTLED = 20.0
_FORGOTTEN = 1e-18


class Signal(NamedTuple):
    """Samples of one trace, in the order of time.

    :param times: when they were taken, in whole nanoseconds
    :param values: what was taken
    :param received: when they were received, or what else tells where they come from
    :param longest: how far apart two samples of one line may be [s]
    """

    times: numpy.ndarray
    values: numpy.ndarray
    received: numpy.ndarray
    longest: float

    def at(self, times: numpy.ndarray) -> numpy.ndarray:
        """Return its values at some times [ns], on the straight line between two samples.

        :returns: NaN where it has a gap, has not begun or has ended
        """
        there = times, numpy.zeros(len(times))
        found: numpy.ndarray = paired((self.times, self.values), there, self.longest * NS)[0]
        return found

    def between(self, start: int, end: int) -> "Signal":
        """Return the samples of a time span, its ends included [ns]."""
        inside = slice(self.times.searchsorted(start), self.times.searchsorted(end, "right"))
        times, values, received = (row[inside] for row in self[:3])
        return Signal(times, values, received, self.longest)


def delayed(signal: Signal, by: int) -> Signal:
    """Return a signal some time later [ns]."""
    return signal._replace(times=signal.times + by)


def slope(signal: Signal) -> Signal:
    """Return the change per second: of two samples, in the middle between them."""
    times, values, received, longest = signal
    steps = numpy.diff(times)
    rising = numpy.full(len(steps), numpy.nan)
    is_step = (steps > 0) & (steps <= longest * NS)
    numpy.divide(numpy.diff(values) * NS, steps, where=is_step, out=rising)
    return Signal(times[:-1] + steps // 2, rising, received[1:], longest)


def low_passed(signal: Signal, cutoff: float) -> Signal:
    """Return what a low-pass of first order makes of a signal that goes straight between samples.

    Of ``T y' = x - y`` with ``T = 1 / (2 pi cutoff)``; it begins with the first sample, and after
    a gap again. Each step is ``y = a y + b``: pairs of steps are joined to one until all are.

    :param cutoff: where the amplitude is down by 3 dB [Hz]
    """
    finite = numpy.isfinite(signal.values)
    times, values = signal.times[finite], signal.values[finite]
    if not len(times):
        return signal
    steps = numpy.diff(times) / NS
    ratio = numpy.clip(steps * (2.0 * math.pi * cutoff), 0.0, None)
    kept = numpy.exp(-ratio)
    late = numpy.divide(1.0 - kept, ratio, where=ratio > 1e-9, out=numpy.ones(len(ratio)))
    changes = numpy.diff(values)
    change = changes * (1.0 - late) + (1.0 - kept) * values[:-1]
    restarts = (steps > signal.longest) | (numpy.diff(numpy.flatnonzero(finite)) > 1)
    kept[restarts], change[restarts] = 0.0, values[1:][restarts]
    factors, sums = numpy.concatenate([[0.0], kept]), numpy.concatenate([values[:1], change])
    shift = 1
    while shift < len(sums) and factors[shift:].max() > _FORGOTTEN:
        sums[shift:] = sums[shift:] + factors[shift:] * sums[:-shift]
        factors[shift:] = factors[shift:] * factors[:-shift]
        shift *= 2
    smooth = numpy.full(len(signal.values), numpy.nan)
    smooth[finite] = sums
    return signal._replace(values=smooth)


def averaged(signal: Signal, window: int) -> Signal:
    """Return the mean of the samples of the last nanoseconds, at each sample.

    The window is open at its begin, so that there are as many samples in each.
    """
    finite = numpy.isfinite(signal.values)
    values = numpy.where(finite, signal.values, 0.0)
    middle = values.sum() / max(int(finite.sum()), 1)  # less is lost of a small change that way
    sums = numpy.concatenate([[0.0], numpy.cumsum(numpy.where(finite, values - middle, 0.0))])
    counts = numpy.concatenate([[0], numpy.cumsum(finite)])
    begin = signal.times.searchsorted(signal.times - window, "right")
    begin = numpy.minimum(begin, numpy.arange(len(values)))
    count = counts[1:] - counts[begin]
    mean = numpy.full(len(values), numpy.nan)
    numpy.divide(sums[1:] - sums[begin], count, where=count > 0, out=mean)
    return signal._replace(values=numpy.where(finite, mean + middle, numpy.nan))


def extreme(signal: Signal, times: numpy.ndarray, reach: int, pick: numpy.ufunc) -> numpy.ndarray:
    """Return the highest or the lowest value around some times.

    Of all values on the lines between samples: at the ends of each span, and at the samples in it.

    :param times: the middles of the spans [ns]
    :param reach: how far a span reaches to either side [ns]
    :param pick: numpy.maximum or numpy.minimum
    :returns: NaN where a span goes beyond what is known, or over a gap
    """
    found = pick(signal.at(times - reach), signal.at(times + reach))
    begin = signal.times.searchsorted(times - reach, "left")
    count = signal.times.searchsorted(times + reach, "right") - begin
    # Of each row the next one: that of spans of twice as many samples. Two such cover any span.
    row, length = signal.values, 1
    while (count >= length).any():
        here = numpy.flatnonzero((count >= length) & (count < 2 * length))
        first, last = begin[here], begin[here] + count[here] - length
        found[here] = pick(found[here], pick(row[first], row[last]))
        row, length = pick(row[:-length], row[length:]), 2 * length
    return numpy.asarray(found)
