"""Reduce samples to what a screen can show: the least and the greatest value of each bin.

Bin ``i`` covers the times from ``i * width`` up to ``(i + 1) * width``, so the bins of all traces
are the same, and those of a later moment too: no sample is shown in one bin now and in another one
a moment later, and a peak of a single sample is never lost. Where a bin has one or two samples it
is also told where in it they stand, so that these are drawn, and not the middles of bins.
"""

from typing import List, NamedTuple, Sequence, Union

import numpy

from topic_scope.analysis.ring import Samples


#: How many parts of a bin are told apart, and up to how many samples in it.
PLACES, FEW = 8, 2


class Bins(NamedTuple):
    """Extremes of the samples in some bins, with a row for each trace.

    :param extremes: as :func:`extremes` returns them
    :param places: for each of these in which part of its bin it stands, from 0; -1 in a bin with
        more than FEW samples, or none
    :param counts: how many samples each bin has that are finite
    """

    extremes: numpy.ndarray
    places: numpy.ndarray
    counts: numpy.ndarray


def bin_of(time: float, width: float) -> int:
    """Return the index of the bin that a time lies in.

    :param time: the time [s]
    :param width: width of the bins [s]
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

    :param times: ascending [s]; from ``longest`` before the first bin on
    :param values: the samples; what is not finite is left out
    :param first: index of the first bin
    :param count: number of bins
    :param width: width of the bins [s]
    :param longest: the longest time between samples of one line [s]
    :returns: min0, max0, min1, max1 and so on; NaN for a bin without a sample, infinity for one
        that no line may cross: with samples of which none is finite, or too long after the last
    """
    return all_bins([(times, values)], first, count, width, [longest]).extremes[0]


def all_bins(
    traces: Sequence[Samples], first: int, count: int, width: float, longest: Sequence[float]
) -> Bins:
    """Return the bins of several traces, which have the same; see :func:`extremes`.

    All at once, as a frame has few samples of each: it is the calls of numpy that take the time.

    :param traces: at least one
    :param longest: for each trace
    """
    times, values = (numpy.concatenate(parts) for parts in zip(*traces))
    size = count + 2  # one more on either side, for what lies outside
    rows = numpy.repeat(numpy.arange(len(traces)) * size, [len(trace[0]) for trace in traces])
    whole = numpy.floor(times / width)
    parts = ((times / width - whole) * PLACES).astype(numpy.int8)
    bins = whole.astype(numpy.int64) - (first - 1)
    bins = numpy.minimum(numpy.maximum(bins, 0), size - 1) + rows
    latest = numpy.full(len(traces) * size, -numpy.inf)
    latest[bins] = times  # of several in a bin the last one stays
    before = numpy.maximum.accumulate(latest.reshape(-1, size), axis=1)
    ends = (first + numpy.arange(size)) * width
    result = numpy.full((len(traces) * size, 2), numpy.nan)
    result[(ends - before > numpy.array(longest)[:, None]).ravel()] = numpy.inf
    places = numpy.full(result.shape, -1, numpy.int8)
    counts = numpy.zeros(len(result), numpy.int64)
    finite = numpy.isfinite(values)
    result[bins[~finite]] = numpy.inf
    bins, values, parts = bins[finite], values[finite], parts[finite]
    if len(bins):
        starts = numpy.append(True, bins[1:] != bins[:-1]).nonzero()[0]
        result[bins[starts], 0] = numpy.minimum.reduceat(values, starts)
        result[bins[starts], 1] = numpy.maximum.reduceat(values, starts)
        stops = numpy.append(starts[1:], len(bins)) - 1
        counts[bins[starts]] = stops - starts + 1
        few = stops - starts < FEW
        one, other = starts[few], stops[few]
        rises = values[one] <= values[other]
        places[bins[one], 0] = parts[numpy.where(rises, one, other)]
        places[bins[one], 1] = parts[numpy.where(rises, other, one)]
    counts = counts.reshape(len(traces), -1)[:, 1:-1]
    return Bins(_inner(result, len(traces)), _inner(places, len(traces)), counts)


def _inner(table: numpy.ndarray, rows: int) -> numpy.ndarray:
    """Drop what lies outside of the bins, and make a row for each trace."""
    return table.reshape(rows, -1, 2)[:, 1:-1].reshape(rows, -1)


def lasts(
    times: numpy.ndarray, values: numpy.ndarray, first: int, count: int, width: float
) -> numpy.ndarray:
    """Return the last sample in each of some bins: the value that holds until the next one.

    :param times: ascending [s]
    :param values: the samples; what is not finite is left out
    :param first: index of the first bin
    :param count: number of bins
    :param width: width of the bins [s]
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
