"""A straight line through points: least squares."""

from typing import NamedTuple, Optional, Sequence, Tuple

#: Fewest points that a line is fitted to.
_FEWEST = 4


class Line(NamedTuple):
    """A straight line.

    :ivar slope: growth for each unit of x
    :ivar offset: value at x = 0
    """

    slope: float
    offset: float

    def at(self, x: float) -> float:
        """Return its value."""
        return self.offset + self.slope * x


def fit_line(points: Sequence[Tuple[float, float]]) -> Optional[Line]:
    """Return the line with the least sum of squares of vertical distances.

    :param points: (x, y)
    :returns: the line; None where the points are too few, or all at one x
    """
    if len(points) < _FEWEST:
        return None
    middle = sum(x for x, _ in points) / len(points)
    mean = sum(y for _, y in points) / len(points)
    spread = sum((x - middle) ** 2 for x, _ in points)
    if spread == 0.0:
        return None
    slope = sum((x - middle) * (y - mean) for x, y in points) / spread
    return Line(slope, mean - slope * middle)
