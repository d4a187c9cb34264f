"""Reduce samples to what a screen can show: the least and the greatest value of each bin.

Bin ``i`` covers the times from ``i * width`` up to ``(i + 1) * width``, so the bins of all traces
are the same, and those of a later moment too: no sample is shown in one bin now and in another one
a moment later, and a peak of a single sample is never lost.
"""

from typing import List, Sequence, Union

import numpy

from topic_scope.analysis.ring import Samples


def bin_of(time: float, width: float) -> int:
    """Return the index of the bin that a time lies in.

    :param time: the time, s
    :param width: width of the bins, s
    """
    return int(numpy.floor(time / width))


def extremes(
    times: numpy.ndarray,
    values: numpy.ndarray,
    first: int,
    count: int,
    width: float,
    longest: float = numpy.inf,
) -> numpy.ndarray:
    """Return the extremes of the samples in each of some bins.

    :param times: ascending, s; from ``longest`` before the first bin on
    :param values: the samples; what is not finite is left out
    :param first: index of the first bin
    :param count: number of bins
    :param width: width of the bins, s
    :param longest: the longest time between samples of one line, s
    :returns: min0, max0, min1, max1 and so on; NaN for a bin without a sample, infinity for one
        that no line may cross: with samples of which none is finite, or too long after the last
    """
    return all_extremes([(times, values)], first, count, width, [longest])[0]


def all_extremes(
    traces: Sequence[Samples], first: int, count: int, width: float, longest: Sequence[float]
) -> numpy.ndarray:
    """Return the extremes of several traces, which have the same bins; see :func:`extremes`.

    All at once, as a frame has few samples of each: it is the calls of numpy that take the time.

    :param traces: at least one
    :param longest: for each trace
    :returns: a row for each trace
    """
    times, values = (numpy.concatenate(parts) for parts in zip(*traces))
    size = count + 2  # one more on either side, for what lies outside
    rows = numpy.repeat(numpy.arange(len(traces)) * size, [len(trace[0]) for trace in traces])
    bins = numpy.floor(times / width).astype(numpy.int64) - (first - 1)
    bins = numpy.minimum(numpy.maximum(bins, 0), size - 1) + rows
    latest = numpy.full(len(traces) * size, -numpy.inf)
    latest[bins] = times  # of several in a bin the last one stays
    before = numpy.maximum.accumulate(latest.reshape(-1, size), axis=1)
    ends = (first + numpy.arange(size)) * width
    result = numpy.full((len(traces) * size, 2), numpy.nan)
    result[(ends - before > numpy.array(longest)[:, None]).ravel()] = numpy.inf
    finite = numpy.isfinite(values)
    result[bins[~finite]] = numpy.inf
    bins, values = bins[finite], values[finite]
    if len(bins):
        starts = numpy.append(True, bins[1:] != bins[:-1]).nonzero()[0]
        result[bins[starts], 0] = numpy.minimum.reduceat(values, starts)
        result[bins[starts], 1] = numpy.maximum.reduceat(values, starts)
    return result.reshape(len(traces), size, 2)[:, 1:-1].reshape(len(traces), -1)


def lasts(
    times: numpy.ndarray, values: numpy.ndarray, first: int, count: int, width: float
) -> numpy.ndarray:
    """Return the last sample in each of some bins: the value that holds until the next one.

    :param times: ascending, s
    :param values: the samples; what is not finite is left out
    :param first: index of the first bin
    :param count: number of bins
    :param width: width of the bins, s
    :returns: a value for each bin; NaN for one without
    """
    result = numpy.full(count, numpy.nan)
    bins = numpy.floor(times / width).astype(numpy.int64) - first
    used = (bins >= 0) & (bins < count) & numpy.isfinite(values)
    result[bins[used]] = values[used]  # of several in a bin the last one stays
    return result


def as_json(values: numpy.ndarray) -> List[Union[float, bool, None]]:
    """Return extremes as JSON knows them: null for nothing, and false for the end of a line.

    :param values: what :func:`extremes` returns
    """
    numbers: List[Union[float, bool, None]] = values.tolist()
    for index in numpy.isnan(values).nonzero()[0].tolist():
        numbers[index] = None
    for index in numpy.isinf(values).nonzero()[0].tolist():
        numbers[index] = False
    return numbers
