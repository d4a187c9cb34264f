"""Find the plant that answers most like a record: least squares, with the doubt of each value."""

import math
from typing import Dict, NamedTuple, Optional, Sequence

import numpy
from scipy.optimize import least_squares

from pid_control.identification.record import IdentificationError, Record
from pid_control.identification.response import (
    DEAD_TIME,
    DEAD_ZONE,
    GAIN,
    LIMIT,
    START,
    TIME_CONSTANT,
    Model,
    candidate,
    responses,
)

#: 95 % of a normal distribution lie within so many standard deviations.
_95_PERCENT = 1.96
#: Where the search begins: the time constant in shares of the record, the dead time in time
#: constants, the gain in those that just reach the largest output, the limit in largest outputs,
#: of which noise may be a part; and by how many outputs, with how many levels of the input.
_TIME_CONSTANTS = numpy.geomspace(0.5e-3, 0.5, 10)
_DEAD_TIMES = (0.0, 0.4, 1.2)
_GAINS = (1.0, 1.4, 2.0, 4.0)
_LIMITS = (1.0, 0.85, 0.7)
_SEARCH_OUTPUTS, _SEARCH_LEVELS = 250, 40
#: An input may have been recorded after it acted, by so much at most, s, and as a share of the
#: record: whoever records may be connected later than the plant. The dead time is below 0 then.
_EARLIEST_S, _EARLIEST = 0.5, 0.05
#: As many outputs are fitted, at most: more cost time and tell little.
_FIT_OUTPUTS = 6000
#: As many thresholds of the dead zone are tried at once.
_ZONES = 40
#: What a value more must make the error smaller by, see :func:`_score`.
_WORTH = 4.0
#: A square error below this one, in shares of the outputs' span, is rounding.
_ROUNDING = 1e-7
#: What must be explained of the outputs, and how much doubt there may be in K and T, in shares.
_LEAST_EXPLAINED, _MOST_DOUBT = 0.5, 0.5


class Identified(NamedTuple):
    """What was found.

    :ivar model: the plant
    :ivar doubt: for each field of the model, by how much it may be wrong: in 95 of 100 records like
        this one the true value is no farther away; infinite where the record cannot tell
    :ivar fitted: what the model answers, at the times of the record
    :ivar residual: the record's outputs less these, root of the mean square
    :ivar explained: share of the outputs' variance that the model explains
    """

    model: Model
    doubt: Model
    fitted: numpy.ndarray
    residual: float
    explained: float


def identify(record: Record) -> Identified:
    """Find K, T, dead time, dead zone and limit.

    The dead zone and the limit are only there where the record says so: where it does without them
    as well, by the Bayesian information criterion (Schwarz, Annals of Statistics 6, 1978), they
    are 0 and infinite. The doubt is that of the linearised problem; where one residual is like the
    next it is greater, as there are fewer that are independent (by (1 + r)/(1 - r), with r their
    correlation; Box, Jenkins, Reinsel: Time Series Analysis, section 2.1).

    :param record: of the plant
    :raises IdentificationError: if the record does not tell, and why
    """
    few = record.thinned(_FIT_OUTPUTS)
    fit = _best_fit(few)
    row = fit.row
    fitted = responses(record, row[None, :])[0]
    errors = record.outputs - fitted
    explained = 1.0 - float(numpy.var(errors) / numpy.var(record.outputs))
    if explained < _LEAST_EXPLAINED:
        raise IdentificationError(
            "the output does not follow the input: a first-order plant explains "
            f"{max(100.0 * explained, 0.0):.0f} % of it"
        )
    doubt = fit.doubt(len(record.times))._replace(dead_zone=_zone_doubt(few, fit))
    model = Model(row[GAIN], row[TIME_CONSTANT], row[DEAD_TIME], row[DEAD_ZONE], row[LIMIT])
    model = Model(*(float(value) for value in model))
    _check_doubt(record, model, doubt)
    residual = math.sqrt(float(numpy.mean(errors**2)))
    return Identified(model, doubt, fitted, residual, explained)


def _check_doubt(record: Record, model: Model, doubt: Model) -> None:
    in_tau = doubt.time_constant / model.time_constant
    in_gain = doubt.gain / abs(model.gain) if model.gain else math.inf
    if in_tau <= _MOST_DOUBT and in_gain <= _MOST_DOUBT:
        return
    if model.time_constant < record.interval:
        why = f"its outputs are {record.interval:.3g} s apart, and the plant is faster"
    elif model.time_constant > 0.5 * record.duration:
        why = f"it lasts {record.duration:.3g} s, and the plant is slower"
    else:
        why = "there is too little in it, or too much noise"
    raise IdentificationError(
        f"by it K would be known {_within(in_gain)} and T {_within(in_tau)}: {why}"
    )


def _within(share: float) -> str:
    return f"within {100.0 * share:.0f} %" if share < 1.0 else "not at all"


class _Fit:
    """The least squares of a record, with a dead zone that is given."""

    def __init__(self, record: Record, row: numpy.ndarray) -> None:
        self._record = record
        self._free = [GAIN, TIME_CONSTANT, DEAD_TIME, START]
        if math.isfinite(row[LIMIT]):
            self._free.append(LIMIT)
        span, scale = record.span, numpy.ones(6)
        scale[GAIN] = abs(row[GAIN]) or 1.0
        scale[TIME_CONSTANT] = scale[DEAD_TIME] = row[TIME_CONSTANT]
        scale[START] = scale[LIMIT] = span
        self._scale = scale[self._free]
        self._row = row
        least = numpy.full(6, -numpy.inf)
        least[TIME_CONSTANT], least[LIMIT] = 1e-4, 1e-6
        least[DEAD_TIME] = -min(_EARLIEST_S, _EARLIEST * record.duration) / row[TIME_CONSTANT]
        largest = numpy.full(6, numpy.inf)
        largest[TIME_CONSTANT] = largest[DEAD_TIME] = record.duration / row[TIME_CONSTANT]
        bounds = least[self._free], largest[self._free]
        begin = numpy.clip(row[self._free] / self._scale, *bounds)
        found = least_squares(self._errors, begin, self._slopes, bounds, max_nfev=60)
        self.row = self._rows(found.x[None, :])[0]
        self._jacobian = found.jac
        self.errors = found.fun
        self.square = float(numpy.sum(found.fun**2))

    @property
    def score(self) -> float:
        """How good it is; less is better."""
        values = len(self._free) + (1 if self.row[DEAD_ZONE] > 0.0 else 0)
        return _score(self._record, self.square, values)

    def doubt(self, outputs: int) -> Model:
        """Return by how much each value may be wrong.

        :param outputs: how many outputs there really are
        """
        count = len(self.errors)
        variance = self.square / (count - len(self._free))
        before, after = self.errors[:-1], self.errors[1:]
        alike = float(before @ after) / (self.square or 1.0)
        alike = min(max(alike, 0.0), 0.999)
        variance *= (1.0 + alike) / (1.0 - alike) * count / outputs
        doubts: Dict[int, float] = {}
        _, singular, axes = numpy.linalg.svd(self._jacobian, full_matrices=False)
        is_told = singular[-1] > 1e-10 * singular[0]
        for number, (column, scale) in enumerate(zip(self._free, self._scale)):
            share = numpy.sum((axes[:, number] / singular) ** 2) if is_told else math.inf
            doubts[column] = _95_PERCENT * scale * math.sqrt(variance * share)
        columns = (GAIN, TIME_CONSTANT, DEAD_TIME, DEAD_ZONE, LIMIT)
        return Model(*(float(doubts.get(column, math.inf)) for column in columns))

    def _rows(self, points: numpy.ndarray) -> numpy.ndarray:
        rows = numpy.tile(self._row, (len(points), 1))
        rows[:, self._free] = points * self._scale
        return rows

    def _errors(self, point: numpy.ndarray) -> numpy.ndarray:
        return responses(self._record, self._rows(point[None, :]))[0] - self._record.outputs

    def _slopes(self, point: numpy.ndarray) -> numpy.ndarray:
        step = 1e-6
        points = numpy.vstack([point, point + step * numpy.eye(len(point))])
        answers = responses(self._record, self._rows(points))
        return (answers[1:] - answers[0]).T / step


def _score(record: Record, square: float, values: int) -> float:
    """Return the Bayesian information criterion of a fit, with a penalty for each value."""
    count = len(record.times)
    floor = count * (_ROUNDING * record.span) ** 2
    return count * math.log(square + floor) + values * (math.log(count) + _WORTH)


def _best_fit(record: Record) -> _Fit:
    largest = float(numpy.abs(record.outputs).max())
    unlimited = _Fit(record, _begin(record, [math.inf]))
    limited = _Fit(record, _begin(record, [largest * share for share in _LIMITS]))
    better, other = sorted([unlimited, limited], key=lambda fit: fit.score)
    with_zone = _with_dead_zone(record, better)
    if with_zone is None or with_zone.score >= better.score:
        return better
    # The dead zone may have been taken for a limit, or have hidden one.
    begin = with_zone.row.copy()
    begin[LIMIT] = other.row[LIMIT]
    return min([with_zone, _Fit(record, begin)], key=lambda fit: fit.score)


def _begin(record: Record, limits: Sequence[float]) -> numpy.ndarray:
    """Return the best of many plants, from where the search begins."""
    few = record.thinned(_SEARCH_OUTPUTS).coarse(_SEARCH_LEVELS)
    start = float(record.outputs[0])
    gain = float(numpy.abs(record.outputs).max() / numpy.abs(record.inputs).max())
    rows = numpy.array(
        [
            candidate(Model(sign * gain * times, tau, tau * delay, 0.0, limit), start)
            for tau in _TIME_CONSTANTS * record.duration
            for delay in _DEAD_TIMES
            for times in _GAINS
            for sign in (1.0, -1.0)
            for limit in limits
        ]
    )
    squares = numpy.sum((responses(few, rows) - few.outputs) ** 2, axis=1)
    best: numpy.ndarray = rows[int(numpy.argmin(squares))]
    return best


def _with_dead_zone(record: Record, fit: _Fit) -> Optional[_Fit]:
    """Return the best fit with a dead zone, if there may be one at all.

    The error only changes with the threshold where that passes an input that was given: so all
    thresholds between two inputs are as good, and the middle is taken.
    """
    levels = numpy.unique(numpy.abs(record.inputs))
    if len(levels) < 2:
        return None
    best: Optional[_Fit] = None
    for _ in range(4):
        row = (best or fit).row
        tried = _Fit(record, _at_best_zone(record, row, levels))
        if best is not None and tried.square >= best.square:
            break
        is_settled = best is not None and tried.row[DEAD_ZONE] == best.row[DEAD_ZONE]
        best = tried
        if is_settled:
            break
    return best


def _at_best_zone(record: Record, row: numpy.ndarray, levels: numpy.ndarray) -> numpy.ndarray:
    """Return a plant with the dead zone that suits it best, the other values kept."""
    middles = 0.5 * (levels[:-1] + levels[1:])
    low, high = 0, len(middles) - 1
    while True:
        chosen = numpy.unique(numpy.linspace(low, high, _ZONES).astype(int))
        squares = _squares(record, row, middles[chosen])
        place = int(numpy.argmin(squares))
        if high - low < _ZONES:
            break
        low = int(chosen[max(place - 1, 0)])
        high = int(chosen[min(place + 1, len(chosen) - 1)])
    found = row.copy()
    found[DEAD_ZONE] = middles[chosen[place]]
    return found


def _squares(record: Record, row: numpy.ndarray, zones: numpy.ndarray) -> numpy.ndarray:
    rows = numpy.tile(row, (len(zones), 1))
    rows[:, DEAD_ZONE] = zones
    squares: numpy.ndarray = numpy.sum((responses(record, rows) - record.outputs) ** 2, axis=1)
    return squares


def _zone_doubt(record: Record, fit: _Fit) -> float:
    """Return how far the farthest threshold is away that is nearly as likely as the best one.

    By the likelihood's ratio: within 95 % the error is no greater than by exp(1.96^2 / count).
    """
    zone = float(fit.row[DEAD_ZONE])
    if zone == 0.0:
        return math.inf
    levels = numpy.unique(numpy.abs(record.inputs))
    place = int(numpy.searchsorted(levels, zone))
    near = levels[max(place - _ZONES // 2, 0) : place + _ZONES // 2]
    middles = 0.5 * (near[:-1] + near[1:])
    squares = _squares(record, fit.row, middles)
    floor = len(record.times) * (_ROUNDING * record.span) ** 2
    most = (fit.square + floor) * math.exp(_95_PERCENT**2 / len(record.times))
    is_likely = squares <= most
    edges = numpy.concatenate([near[:-1][is_likely], near[1:][is_likely], [zone]])
    return float(numpy.abs(edges - zone).max())
