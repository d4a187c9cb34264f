"""XY display: samples of two traces, paired by time."""

import numpy

from topic_scope.analysis.ring import Samples

#: Most points of a line.
LONGEST = 4000
#: Most points kept of a stretch: its ends, its extremes, and the end of a line.
_OF_EACH = 7
#: Points closer to the previous point than this fraction of the range are left out.
_FINE = 1.0 / 2000


def paired(x: Samples, y: Samples, longest: float) -> numpy.ndarray:
    """Return one trace against another.

    :param x: times in s or ns, ascending, and values of the horizontal trace
    :param y: times and values of the vertical trace
    :param longest: the longest time between two samples of x to interpolate in [s]
    :returns: x and y at the times of y; both NaN if x is unknown, or either is not finite
    """
    (times, right), (moments, up) = x, y
    points = numpy.full((2, len(moments)), numpy.nan)
    if len(times):
        after = numpy.clip(numpy.searchsorted(times, moments, "left"), 0, len(times) - 1)
        before = numpy.where(times[after] > moments, numpy.maximum(after - 1, 0), after)
        known = (times[before] <= moments) & (times[after] >= moments)
        known &= (times[after] - times[before] <= longest) & numpy.isfinite(up)
        width = times[after] - times[before]
        part = numpy.divide(moments - times[before], width, where=width > 0, out=width * 0.0)
        with numpy.errstate(invalid="ignore", over="ignore"):
            at = right[before] * (1.0 - part) + numpy.where(part > 0, right[after], 0.0) * part
        known &= numpy.isfinite(at)
        points[:, known] = at[known], up[known]
    return points


def thinned(points: numpy.ndarray) -> numpy.ndarray:
    """Drop points that a screen cannot distinguish from the previous point.

    :param points: as :func:`paired` returns them
    """
    finite = numpy.isfinite(points[0])
    if not finite.any():
        return points[:, :0]
    low, high = points[:, finite].min(axis=1), points[:, finite].max(axis=1)
    # Halved, so that the full range of floats does not overflow.
    fine = numpy.maximum((high / 2 - low / 2) * _FINE, numpy.finfo(float).tiny)
    places = numpy.floor((points.T / 2 - low / 2) / fine).T
    same = (places[:, 1:] == places[:, :-1]).all(axis=0) | ~(finite[1:] | finite[:-1])
    kept = numpy.concatenate([[True], ~same])
    kept[-1] = True
    points = points[:, kept]
    return points if points.shape[1] <= LONGEST else _extremes(points)


def _extremes(points: numpy.ndarray) -> numpy.ndarray:
    """Return the extremes of each stretch in both directions, and the end of its line."""
    size = -(-points.shape[1] * _OF_EACH // LONGEST)
    places = numpy.arange(-(-points.shape[1] // size) * size).reshape(-1, size)
    places = numpy.minimum(places, points.shape[1] - 1)
    kept = [places[:, :1], places[:, -1:]]
    for row in points:
        there = ~numpy.isnan(row[places])
        for fill, pick in ((numpy.inf, numpy.argmin), (-numpy.inf, numpy.argmax)):
            best = pick(numpy.where(there, row[places], fill), axis=1)
            kept.append(numpy.take_along_axis(places, best[:, None], 1))
    ends = numpy.isnan(points[0][places]).argmax(axis=1)
    kept.append(numpy.take_along_axis(places, ends[:, None], 1))
    return points[:, numpy.unique(numpy.concatenate(kept))]
