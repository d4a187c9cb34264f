"""Sampled signals, and their derivative, low-pass, moving average and extremes."""

import math
from typing import NamedTuple

import numpy

from topic_scope.analysis.xy import paired
from topic_scope.timing.nanoseconds import NS

#: Number of time constants after which a low-pass has settled to 2e-9.
SETTLED = 20.0
_FORGOTTEN = 1e-18


class Signal(NamedTuple):
    """Samples of one trace, in time order.

    :param times: when they were taken, in whole nanoseconds
    :param values: the values
    :param received: receipt times, or other identification of their messages
    :param longest: longest time between connected samples [s]
    """

    times: numpy.ndarray
    values: numpy.ndarray
    received: numpy.ndarray
    longest: float

    def at(self, times: numpy.ndarray) -> numpy.ndarray:
        """Return the values at some times [ns], linearly interpolated.

        :returns: NaN in a gap, and before the first and after the last sample
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
    """Return a delayed signal [ns]."""
    return signal._replace(times=signal.times + by)


def slope(signal: Signal) -> Signal:
    """Return the derivative per second, midway between successive samples."""
    times, values, received, longest = signal
    steps = numpy.diff(times)
    rising = numpy.full(len(steps), numpy.nan)
    is_step = (steps > 0) & (steps <= longest * NS)
    numpy.divide(numpy.diff(values) * NS, steps, where=is_step, out=rising)
    return Signal(times[:-1] + steps // 2, rising, received[1:], longest)


def low_passed(signal: Signal, cutoff: float) -> Signal:
    """Return a signal filtered by a first-order low-pass, for linear input between samples.

    Solves ``T y' = x - y`` with ``T = 1 / (2 pi cutoff)``, restarted at the first sample after each
    gap. Each step is ``y = a y + b``; pairs of steps are combined until all are.

    :param cutoff: frequency of -3 dB [Hz]
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
    """Return the moving average at each sample, over a window [ns].

    The window is open at its start, so that all windows have the same number of samples.
    """
    finite = numpy.isfinite(signal.values)
    values = numpy.where(finite, signal.values, 0.0)
    middle = values.sum() / max(int(finite.sum()), 1)  # subtracted, to keep small changes exact
    sums = numpy.concatenate([[0.0], numpy.cumsum(numpy.where(finite, values - middle, 0.0))])
    counts = numpy.concatenate([[0], numpy.cumsum(finite)])
    begin = signal.times.searchsorted(signal.times - window, "right")
    count = counts[1:] - counts[begin]
    mean = numpy.full(len(values), numpy.nan)
    numpy.divide(sums[1:] - sums[begin], count, where=count > 0, out=mean)
    return signal._replace(values=numpy.where(finite, mean + middle, numpy.nan))


def extreme(signal: Signal, times: numpy.ndarray, reach: int, pick: numpy.ufunc) -> numpy.ndarray:
    """Return the maximum or minimum around some times.

    Interpolated between samples, so it is evaluated at the ends of each span and at its samples.

    :param times: the middles of the spans [ns]
    :param reach: half-width of the spans [ns]
    :param pick: numpy.maximum or numpy.minimum
    :returns: NaN if a span exceeds the samples or contains a gap
    """
    found = pick(signal.at(times - reach), signal.at(times + reach))
    begin = signal.times.searchsorted(times - reach, "left")
    count = signal.times.searchsorted(times + reach, "right") - begin
    # Each row covers spans of twice as many samples as the row before; two spans cover any span.
    row, length = signal.values, 1
    while (count >= length).any():
        here = numpy.flatnonzero((count >= length) & (count < 2 * length))
        first, last = begin[here], begin[here] + count[here] - length
        found[here] = pick(found[here], pick(row[first], row[last]))
        row, length = pick(row[:-length], row[length:]), 2 * length
    return numpy.asarray(found)
