"""Least-squares fit of a straight line."""

from typing import NamedTuple, Optional, Sequence, Tuple

import numpy

#: Fewest points of a fit.
_FEWEST = 4


class Line(NamedTuple):
    """A straight line.

    :ivar slope: change per unit of x
    :ivar offset: value at x = 0
    """

    slope: float
    offset: float

    def at(self, x: float) -> float:
        """Return the line's value."""
        return self.offset + self.slope * x


def fit_line(points: Sequence[Tuple[float, float]]) -> Optional[Line]:
    """Fit a line with the least sum of squared vertical distances.

    :param points: (x, y)
    :returns: the line; None for too few points, or if all have the same x
    """
    if len(points) < _FEWEST:
        return None
    x, y = numpy.array(points).T
    if x.max() == x.min():
        return None
    offset, slope = numpy.polynomial.polynomial.polyfit(x, y, 1)
    return Line(float(slope), float(offset))
