"""Least-squares fit of a plant to a record, with the uncertainty of each value."""

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

#: Standard deviations that contain 95 % of a normal distribution.
_95_PERCENT = 1.96
#: Start values of the search: time constants as shares of the record, dead times in time constants,
#: gains as multiples of the gain that just reaches the largest output, limits as shares of the
#: largest output (which may contain noise); and the numbers of outputs and input levels used.
_TIME_CONSTANTS = numpy.geomspace(0.5e-3, 0.5, 10)
_DEAD_TIMES = (0.0, 0.4, 1.2)
_GAINS = (1.0, 1.4, 2.0, 4.0)
_LIMITS = (1.0, 0.85, 0.7)
_SEARCH_OUTPUTS, _SEARCH_LEVELS = 250, 40
#: Longest delay with which an input may have been recorded after it acted, in [s] and as a share of
#: the record: a recorder may connect later than the plant. The fitted dead time is negative then.
_EARLIEST_S, _EARLIEST = 0.5, 0.05
#: Most outputs that are fitted: more take time and add little accuracy.
_FIT_OUTPUTS = 6000
#: Number of dead zone thresholds that are tried at once.
_ZONES = 40
#: Extra penalty for each additional value, see :func:`_score`.
_WORTH = 4.0
#: Error that counts as rounding, as a share of the outputs' span.
_ROUNDING = 1e-7
#: Least share of the outputs' variance to explain, and largest relative uncertainty of K and T.
_LEAST_EXPLAINED, _MAX_UNCERTAINTY = 0.5, 0.5


class Identified(NamedTuple):
    """Result of an identification.

    :ivar model: the plant
    :ivar uncertainty: half width of the 95 % confidence interval of each field of the model;
        infinite if the record does not determine the value
    :ivar fitted: the model's outputs at the times of the record
    :ivar residual: root mean square of the record's outputs minus the fitted ones
    :ivar explained: share of the outputs' variance that the model explains
    """

    model: Model
    uncertainty: Model
    fitted: numpy.ndarray
    residual: float
    explained: float


def identify(record: Record) -> Identified:
    """Identify K, T, dead time, dead zone and limit.

    Dead zone and limit are part of the model only if they improve the Bayesian information
    criterion (Schwarz, Annals of Statistics 6, 1978); otherwise they are 0 and infinite. The
    uncertainty is that of the linearised problem, enlarged by (1 + r)/(1 - r) for residuals with
    autocorrelation r (Box, Jenkins, Reinsel: Time Series Analysis, section 2.1).

    :param record: a record of the plant
    :raises IdentificationError: if the record does not determine the plant; the message says why
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
    uncertainty = fit.uncertainty(len(record.times))._replace(dead_zone=_zone_uncertainty(few, fit))
    model = Model(row[GAIN], row[TIME_CONSTANT], row[DEAD_TIME], row[DEAD_ZONE], row[LIMIT])
    model = Model(*(float(value) for value in model))
    _check_uncertainty(record, model, uncertainty)
    residual = math.sqrt(float(numpy.mean(errors**2)))
    return Identified(model, uncertainty, fitted, residual, explained)


def _check_uncertainty(record: Record, model: Model, uncertainty: Model) -> None:
    in_tau = uncertainty.time_constant / model.time_constant
    in_gain = uncertainty.gain / abs(model.gain) if model.gain else math.inf
    if in_tau <= _MAX_UNCERTAINTY and in_gain <= _MAX_UNCERTAINTY:
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
    """Least-squares fit of a record, with a fixed dead zone."""

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
        """The information criterion of the fit; less is better."""
        values = len(self._free) + (1 if self.row[DEAD_ZONE] > 0.0 else 0)
        return _score(self._record, self.square, values)

    def uncertainty(self, outputs: int) -> Model:
        """Return the uncertainty of each value.

        :param outputs: number of outputs of the whole record
        """
        count = len(self.errors)
        variance = self.square / (count - len(self._free))
        before, after = self.errors[:-1], self.errors[1:]
        alike = float(before @ after) / (self.square or 1.0)
        alike = min(max(alike, 0.0), 0.999)
        variance *= (1.0 + alike) / (1.0 - alike) * count / outputs
        uncertainties: Dict[int, float] = {}
        _, singular, axes = numpy.linalg.svd(self._jacobian, full_matrices=False)
        is_told = singular[-1] > 1e-10 * singular[0]
        for number, (column, scale) in enumerate(zip(self._free, self._scale)):
            share = numpy.sum((axes[:, number] / singular) ** 2) if is_told else math.inf
            uncertainties[column] = _95_PERCENT * scale * math.sqrt(variance * share)
        columns = (GAIN, TIME_CONSTANT, DEAD_TIME, DEAD_ZONE, LIMIT)
        return Model(*(float(uncertainties.get(column, math.inf)) for column in columns))

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
    # Without the dead zone the fit may have found a false limit, or missed the true one.
    begin = with_zone.row.copy()
    begin[LIMIT] = other.row[LIMIT]
    return min([with_zone, _Fit(record, begin)], key=lambda fit: fit.score)


def _begin(record: Record, limits: Sequence[float]) -> numpy.ndarray:
    """Return the best of many start values."""
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
    """Return the best fit with a dead zone; None if the record cannot show one.

    The error is constant for all thresholds between two neighbouring input levels, so the middle
    is used.
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
    """Return a plant with its best dead zone, the other values unchanged."""
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


def _zone_uncertainty(record: Record, fit: _Fit) -> float:
    """Return the uncertainty of the dead zone, by the likelihood ratio.

    Within 95 % the squared error is larger than the least one by a factor of at most
    exp(1.96^2 / count).
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
