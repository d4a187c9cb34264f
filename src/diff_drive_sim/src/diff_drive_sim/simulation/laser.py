"""Ranges of a laser scanner, vectorised over all rays and walls."""

from typing import Sequence

import numpy

#: A ray that passes the end of a wall by less than this still hits it, relative to the wall's
#: length: rounding must not let it through a corner.
_CORNER = 1e-12


class Laser:
    """Ray caster over 360°: the first ray points ahead, the others follow counter-clockwise.

    :param segments: walls, each from x, y to x, y [m]
    :param rays: number of rays
    """

    def __init__(self, segments: Sequence[Sequence[float]], rays: int) -> None:
        walls = numpy.asarray(segments, dtype=float).reshape(-1, 4)
        self._starts, self._along = walls[:, :2], walls[:, 2:] - walls[:, :2]
        self._angles = numpy.arange(rays) * (2.0 * numpy.pi / rays)

    def ranges(self, x: float, y: float, theta: float) -> numpy.ndarray:
        """Return the distance to the nearest wall along each ray [m]; infinite without a wall.

        With a wall from a along s, a ray from p in the direction d meets it at p + t d = a + u s,
        where t = (a - p) x s / (d x s) and u = (a - p) x d / (d x s).

        :param x: of the laser [m]
        :param y: of the laser [m]
        :param theta: direction of the first ray [rad]
        """
        if not len(self._starts):
            return numpy.full(len(self._angles), numpy.inf)
        ray_x, ray_y = numpy.cos(self._angles + theta), numpy.sin(self._angles + theta)
        to_x, to_y = self._starts[:, 0] - x, self._starts[:, 1] - y
        along_x, along_y = self._along[:, 0], self._along[:, 1]
        slant = numpy.outer(ray_x, along_y) - numpy.outer(ray_y, along_x)
        # Along a wall, or beside it, the quotients are infinite or NaN.
        with numpy.errstate(divide="ignore", invalid="ignore", over="ignore"):
            distance = (to_x * along_y - to_y * along_x) / slant
            part = (numpy.outer(ray_y, to_x) - numpy.outer(ray_x, to_y)) / slant
        meets = (distance >= 0.0) & (part >= -_CORNER) & (part <= 1.0 + _CORNER)
        return numpy.where(meets, distance, numpy.inf).min(axis=1)
