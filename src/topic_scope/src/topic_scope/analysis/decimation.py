"""Reduction of samples to screen resolution: minimum and maximum of each bin.

Bin ``i`` covers the times from ``i * width`` up to ``(i + 1) * width``, so all traces share their
bins, now and later: a sample never moves from one bin to another, and a peak of a single sample is
never lost. For a bin with one or two samples, their positions in the bin are returned as well, so
that they are drawn at their times, not at the middle of the bin.
"""

from typing import List, NamedTuple, Sequence, Union

import numpy

from topic_scope.analysis.ring import Samples


#: Resolution of positions inside a bin, and the most samples in a bin that have positions.
PLACES, FEW = 8, 2


class Bins(NamedTuple):
    """Extremes of the samples in some bins, one row per trace.

    :param extremes: as :func:`extremes` returns them
    :param places: part of the bin in which each extreme lies, from 0; -1 in a bin with more than
        FEW samples, or without samples
    :param counts: number of finite samples in each bin
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
    """Return the extremes of the samples in each bin.

    :param times: ascending [s]; starting ``longest`` before the first bin
    :param values: the samples; non-finite values are ignored
    :param first: index of the first bin
    :param count: number of bins
    :param width: width of the bins [s]
    :param longest: the longest time between samples that a line connects [s]
    :returns: min0, max0, min1, max1 and so on; NaN for a bin without samples, infinity for a bin
        that no line may cross: it has no finite sample, or lies too long after the last sample
    """
    return all_bins([(times, values)], first, count, width, [longest]).extremes[0]


def all_bins(
    traces: Sequence[Samples], first: int, count: int, width: float, longest: Sequence[float]
) -> Bins:
    """Return the bins of several traces, which share the same grid; see :func:`extremes`.

    All traces in one pass: a frame has few samples of each, so numpy's call overhead dominates.

    :param traces: at least one
    :param longest: for each trace
    """
    times, values = (numpy.concatenate(parts) for parts in zip(*traces))
    size = count + 2  # one extra on either side, for samples outside
    rows = numpy.repeat(numpy.arange(len(traces)) * size, [len(trace[0]) for trace in traces])
    whole = numpy.floor(times / width)
    parts = ((times / width - whole) * PLACES).astype(numpy.int8)
    bins = whole.astype(numpy.int64) - (first - 1)
    bins = numpy.minimum(numpy.maximum(bins, 0), size - 1) + rows
    latest = numpy.full(len(traces) * size, -numpy.inf)
    latest[bins] = times  # the last of several samples in a bin wins
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
    """Drop the outer bins, and return a row for each trace."""
    return table.reshape(rows, -1, 2)[:, 1:-1].reshape(rows, -1)


def lasts(
    times: numpy.ndarray, values: numpy.ndarray, first: int, count: int, width: float
) -> numpy.ndarray:
    """Return the last sample in each bin: the value that holds until the next sample.

    :param times: ascending [s]
    :param values: the samples; non-finite values are ignored
    :param first: index of the first bin
    :param count: number of bins
    :param width: width of the bins [s]
    :returns: a value for each bin; NaN for a bin without samples
    """
    result = numpy.full(count, numpy.nan)
    bins = numpy.floor(times / width).astype(numpy.int64) - first
    used = (bins >= 0) & (bins < count) & numpy.isfinite(values)
    result[bins[used]] = values[used]  # the last of several samples in a bin wins
    return result


def as_json(values: numpy.ndarray) -> List[Union[float, bool, None]]:
    """Return extremes as JSON values: null for an empty bin, false for the end of a line.

    :param values: as returned by :func:`extremes`
    """
    numbers: List[Union[float, bool, None]] = values.tolist()
    for index in numpy.isnan(values).nonzero()[0].tolist():
        numbers[index] = None
    for index in numpy.isinf(values).nonzero()[0].tolist():
        numbers[index] = False
    return numbers
