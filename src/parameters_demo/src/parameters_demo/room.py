# Pure: knows no ROS.
"""Room of the simulated lidar: a hall with a door, a cabinet, a pillar, and a walking person.

The lidar is at the origin and faces along x. Lengths are in m, angles in rad, times in s.
"""

import math
from typing import NamedTuple, Tuple

import numpy

#: Corners of open polylines; the gap of the first one is the door.
_WALLS = (
    ((6.0, 0.7), (6.0, 3.0), (-4.0, 3.0), (-4.0, -3.0), (6.0, -3.0), (6.0, -0.7)),
    ((-2.5, -2.0), (-1.5, -2.0), (-1.5, -1.5), (-2.5, -1.5), (-2.5, -2.0)),
)
#: Centre and radius of the pillar.
_PILLAR = ((2.5, 1.5), 0.2)
#: Radius of the person, semi-axes of the elliptic path, and time per round.
PERSON_RADIUS, _ROUND_X, _ROUND_Y, ROUND_S = 0.25, 2.0, 1.2, 12.0

Point = Tuple[float, float]


class Scanner(NamedTuple):
    """Rays and range of a lidar.

    :param angle_min: direction of the first ray, counter-clockwise from x
    :param angle_max: direction of the last ray
    :param rays: number of rays
    :param range_min: shortest range
    :param range_max: longest range
    """

    angle_min: float
    angle_max: float
    rays: int
    range_min: float
    range_max: float

    @property
    def angle_increment(self) -> float:
        """Angle between adjacent rays."""
        return (self.angle_max - self.angle_min) / (self.rays - 1)


#: Scanners by model. The names are from a real family of lidars, the figures are made up.
MODELS = {
    "OS0": Scanner(-math.pi, math.pi, 361, 0.1, 4.0),
    "OS1": Scanner(-math.pi, math.pi, 721, 0.1, 8.0),
    "OS2": Scanner(-math.pi, math.pi, 1441, 0.3, 20.0),
    "DF": Scanner(-math.pi / 3, math.pi / 3, 241, 0.1, 8.0),
}


def person(time: float) -> Point:
    """Return the position of the person.

    :param time: any time
    """
    angle = math.tau * (time / ROUND_S % 1.0)
    return _ROUND_X * math.cos(angle), _ROUND_Y * math.sin(angle)


def scan(scanner: Scanner, time: float) -> numpy.ndarray:
    """Return the measurement of a lidar.

    :param scanner: the lidar
    :param time: time of the scan
    :returns: a distance for each ray; as in REP 117, inf if nothing is in range, and -inf if an
        object is too near
    """
    angles = numpy.linspace(scanner.angle_min, scanner.angle_max, scanner.rays)
    found = distances(angles, time)
    found[found > scanner.range_max] = numpy.inf
    found[found < scanner.range_min] = -numpy.inf
    return found


def distances(angles: numpy.ndarray, time: float) -> numpy.ndarray:
    """Return the distance to the first obstacle in each direction; inf without one.

    :param angles: the directions
    :param time: time of the scan
    """
    rays = numpy.stack([numpy.cos(angles), numpy.sin(angles)], axis=1)
    found = _to_walls(rays)
    for centre, radius in (_PILLAR, (person(time), PERSON_RADIUS)):
        found = numpy.minimum(found, _to_circle(rays, numpy.array(centre), radius))
    return found


_STARTS = numpy.array([point for wall in _WALLS for point in wall[:-1]])
_SIDES = numpy.array([point for wall in _WALLS for point in wall[1:]]) - _STARTS


def _to_walls(rays: numpy.ndarray) -> numpy.ndarray:
    """Solve distance * ray = start + part * side for each ray and each side."""
    with numpy.errstate(all="ignore"):
        across = _cross(rays[:, None], _SIDES)  # 0 where they are parallel
        distance = _cross(_STARTS, _SIDES) / across
        part = _cross(_STARTS, rays[:, None]) / across
        hits = (distance > 0.0) & (part >= 0.0) & (part <= 1.0)
    return numpy.where(hits, distance, numpy.inf).min(axis=1)


def _to_circle(rays: numpy.ndarray, centre: numpy.ndarray, radius: float) -> numpy.ndarray:
    along = rays @ centre
    inside = radius**2 - (centre @ centre - along**2)
    hits = (inside >= 0.0) & (along > 0.0)
    return numpy.where(hits, along - numpy.sqrt(numpy.maximum(inside, 0.0)), numpy.inf)


def _cross(one: numpy.ndarray, other: numpy.ndarray) -> numpy.ndarray:
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
