"""Least-squares fit of a plant with given terms to a record."""

import math
from typing import Dict, FrozenSet

import numpy
from scipy import optimize

from pid_control.identification.noise import covariance_of_sums, outputs_per_independent_one
from pid_control.identification.record import Record
from pid_control.identification.response import (
    DEAD_TIME,
    DEAD_ZONE,
    FRICTION,
    GAIN,
    LIMIT,
    OFFSET,
    START,
    TIME_CONSTANT,
    Model,
    responses,
)

#: Standard deviations that contain 95 % of a normal distribution.
_95_PERCENT = 1.96
#: Longest delay with which an input may have been recorded after it acted, in [s] and as a share of
#: the record: a recorder may connect later than the plant. The fitted dead time is negative then.
_EARLIEST_S, _EARLIEST = 0.5, 0.05
#: Number of dead zone thresholds that are tried together.
ZONES = 40
#: Error that counts as rounding, as a share of the outputs' span.
ROUNDING = 1e-7
#: Values of a term that is not part of the model.
ABSENT = {DEAD_ZONE: 0.0, LIMIT: math.inf, OFFSET: 0.0, FRICTION: 0.0}

Terms = FrozenSet[int]


class Fit:
    """Least-squares fit of a record with a fixed dead zone.

    :param record: a record of the plant
    :param row: start values, as in :func:`.responses`
    :param terms: the columns of ABSENT that are part of the model
    """

    def __init__(self, record: Record, row: numpy.ndarray, terms: Terms) -> None:
        self.record, self.terms = record, terms
        self._row = row.copy()
        for column, value in ABSENT.items():
            if column not in terms:
                self._row[column] = value
        optional = [column for column in (LIMIT, OFFSET, FRICTION) if column in terms]
        self._free = [GAIN, TIME_CONSTANT, DEAD_TIME, START, *optional]
        span, tau, largest_input = record.span, row[TIME_CONSTANT], numpy.abs(record.inputs).max()
        scale, least, largest = numpy.ones(8), numpy.full(8, -numpy.inf), numpy.full(8, numpy.inf)
        scale[GAIN] = abs(row[GAIN]) or 1.0
        scale[TIME_CONSTANT] = scale[DEAD_TIME] = tau
        scale[START] = scale[LIMIT] = scale[OFFSET] = span
        scale[FRICTION] = largest_input
        least[TIME_CONSTANT], least[LIMIT], least[FRICTION] = 1e-4, 1e-6, 0.0
        least[DEAD_TIME] = -min(_EARLIEST_S, _EARLIEST * record.duration) / tau
        largest[TIME_CONSTANT] = largest[DEAD_TIME] = record.duration / tau
        largest[FRICTION] = 1.0
        self._scale = scale[self._free]
        bounds = least[self._free], largest[self._free]
        begin = numpy.clip(self._row[self._free] / self._scale, *bounds)
        found = optimize.least_squares(self._errors, begin, self._slopes, bounds, max_nfev=60)
        self.row = self._rows(found.x[None, :])[0]
        self._jacobian = found.jac
        self.errors = found.fun
        self.square = float(numpy.sum(found.fun**2))
        #: How many outputs count as one independent one.
        self.per_independent = outputs_per_independent_one(found.fun)

    def uncertainty(self) -> Model:
        """Return the half width of the 95 % confidence interval of each value; infinite if unknown.

        Computed for the linearised problem with autocorrelated noise: with the slopes J and the
        noise's covariance S, ``(J' J)^-1 J' S J (J' J)^-1`` (Ljung: System Identification, 2nd
        edition, section 9.4).
        """
        independent = len(self.errors) / self.per_independent
        variance = self.square / len(self.errors)
        variance *= independent / max(independent - len(self._free), 1.0)
        deviations = numpy.full(len(self._free), math.inf)
        singular = numpy.linalg.svd(self._jacobian, compute_uv=False)
        if singular[-1] > 1e-10 * singular[0]:
            inverse = numpy.linalg.pinv(self._jacobian.T @ self._jacobian)
            noise = covariance_of_sums(self._jacobian, self.per_independent)
            deviations = numpy.sqrt(variance * numpy.diag(inverse @ noise @ inverse).clip(0.0))
        widths: Dict[int, float] = {
            column: float(_95_PERCENT * scale * deviation)
            for column, scale, deviation in zip(self._free, self._scale, deviations)
        }
        widths[DEAD_ZONE] = self._zone_uncertainty()
        columns = (GAIN, TIME_CONSTANT, DEAD_TIME, DEAD_ZONE, LIMIT, OFFSET, FRICTION)
        return Model(*(widths.get(column, math.inf) for column in columns))

    def _zone_uncertainty(self) -> float:
        """Return the uncertainty of the dead zone, by the likelihood ratio.

        Within 95 % the squared error is larger than the least one by a factor of at most
        exp(1.96^2 / n), where n is the number of independent outputs.
        """
        zone = float(self.row[DEAD_ZONE])
        if DEAD_ZONE not in self.terms:
            return math.inf
        count = len(self.record.times)
        levels = numpy.unique(numpy.abs(self.record.inputs))
        place = int(numpy.searchsorted(levels, zone))
        near = levels[max(place - ZONES // 2, 0) : place + ZONES // 2]
        squares = squares_of_zones(self.record, self.row, 0.5 * (near[:-1] + near[1:]))
        floor = count * (ROUNDING * self.record.span) ** 2
        factor = math.exp(_95_PERCENT**2 * self.per_independent / count)
        is_likely = squares <= (self.square + floor) * factor
        edges = numpy.concatenate([near[:-1][is_likely], near[1:][is_likely], [zone]])
        return float(numpy.abs(edges - zone).max())

    def _rows(self, points: numpy.ndarray) -> numpy.ndarray:
        rows = numpy.tile(self._row, (len(points), 1))
        rows[:, self._free] = points * self._scale
        return rows

    def _errors(self, point: numpy.ndarray) -> numpy.ndarray:
        return responses(self.record, self._rows(point[None, :]))[0] - self.record.outputs

    def _slopes(self, point: numpy.ndarray) -> numpy.ndarray:
        step = 1e-6
        points = numpy.vstack([point, point + step * numpy.eye(len(point))])
        answers = responses(self.record, self._rows(points))
        return (answers[1:] - answers[0]).T / step


def squares_of(record: Record, rows: numpy.ndarray) -> numpy.ndarray:
    """Return the sum of squared errors of each plant.

    :param record: a record of the plant
    :param rows: plants, as in :func:`.responses`
    """
    squares: numpy.ndarray = numpy.sum((responses(record, rows) - record.outputs) ** 2, axis=1)
    return squares


def squares_of_zones(record: Record, row: numpy.ndarray, zones: numpy.ndarray) -> numpy.ndarray:
    """Return the sum of squared errors with each dead zone, the other values unchanged.

    :param record: a record of the plant
    :param row: the plant, as in :func:`.responses`
    :param zones: the dead zones
    """
    rows = numpy.tile(row, (len(zones), 1))
    rows[:, DEAD_ZONE] = zones
    return squares_of(record, rows)
