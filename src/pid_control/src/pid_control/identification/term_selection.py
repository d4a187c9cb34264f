"""Selection of a plant model's terms (dead zone, limit, offset, friction) by Bayesian criterion."""

import math
from typing import List, Optional

import numpy

from pid_control.identification.least_squares import (
    ROUNDING,
    ZONES,
    Fit,
    Terms,
    squares_of,
    squares_of_zones,
)
from pid_control.identification.record import Record
from pid_control.identification.response import (
    DEAD_ZONE,
    FRICTION,
    GAIN,
    LIMIT,
    OFFSET,
    Model,
    candidate,
    responses,
)

#: Start values of the search: time constants as shares of the record, dead times in time constants,
#: gains as multiples of the gain that just reaches the largest output, limits as shares of the
#: largest output (which may contain noise), friction as shares of the largest input; and the
#: numbers of outputs and input levels used.
_TIME_CONSTANTS = numpy.geomspace(0.5e-3, 0.5, 10)
_DEAD_TIMES = (0.0, 0.4, 1.2)
_GAINS = (1.0, 1.4, 2.0, 4.0)
_LIMITS = (1.0, 0.85, 0.7)
_FRICTIONS = (0.02, 0.05, 0.1, 0.2, 0.4)
_SEARCH_OUTPUTS, _SEARCH_LEVELS = 250, 40
#: Number of outputs for the choice of terms, and for the final fit: more take time and add little
#: accuracy.
_CHOICE_OUTPUTS, _FIT_OUTPUTS = 1000, 6000
#: Extra penalty for each additional value, see :class:`_Evidence`.
_WORTH = 4.0
#: Most changes of the terms.
_MOST_CHANGES = 8
_NOTHING: Terms = frozenset()


def best_fit(record: Record) -> Fit:
    """Return the fit with those terms that the record shows.

    :param record: a record of the plant
    """
    few = record.thinned(_CHOICE_OUTPUTS)
    criterion = _InformationCriterion(few)
    fits = _first_fits(few)
    # The whole model first: the residual of a smaller model is more than noise.
    for term in (DEAD_ZONE, LIMIT, OFFSET):
        closest = min(fits, key=lambda fit: fit.square)
        if term not in closest.terms:
            fits += _fits(few, closest, [closest.terms | {term}])
    best = criterion.best(fits)
    choices = _without_friction
    for _ in range(_MOST_CHANGES):
        better = criterion.best([best, *_fits(few, best, choices(best.terms))])
        if better is best and choices is _with_friction:
            break
        # Friction takes the most time, so it is tried last.
        choices = _with_friction if better is best else _without_friction
        best = better
    if len(record.times) <= _CHOICE_OUTPUTS:
        return best
    return _fit(record.thinned(_FIT_OUTPUTS), best.row, best.terms) or best


class _InformationCriterion:
    """Bayesian information criterion (Schwarz, Annals of Statistics 6, 1978).

    The number of independent outputs is computed from the residual of the closest fit so far: a
    missing term would also make a residual autocorrelated.
    """

    def __init__(self, record: Record) -> None:
        self._count = len(record.times)
        self._floor = self._count * (ROUNDING * record.span) ** 2
        self._closest: Optional[Fit] = None

    def best(self, fits: List[Fit]) -> Fit:
        """Return the fit with the least criterion; the first of equal ones."""
        closest = min(fits, key=lambda fit: fit.square)
        if self._closest is None or closest.square < self._closest.square:
            self._closest = closest
        independent = self._count / self._closest.per_independent
        return min(fits, key=lambda fit: self._score(fit, independent))

    def _score(self, fit: Fit, independent: float) -> float:
        penalty = math.log(independent) + _WORTH
        return independent * math.log(fit.square + self._floor) + len(fit.terms) * penalty


def _first_fits(record: Record) -> List[Fit]:
    """Return fits with and without a limit and an offset, from the best of many start values."""
    line = _line(record)
    fits = [Fit(record, line, frozenset({OFFSET}))]
    for offset in (0.0, float(line[OFFSET])):
        terms: Terms = frozenset({OFFSET}) if offset else _NOTHING
        largest = float(numpy.abs(record.outputs - offset).max())
        limits = [largest * share for share in _LIMITS]
        fits += [
            Fit(record, _begin(record, [math.inf], offset), terms),
            Fit(record, _begin(record, limits, offset), terms | {LIMIT}),
        ]
    return fits


def _begin(record: Record, limits: List[float], offset: float) -> numpy.ndarray:
    few = record.thinned(_SEARCH_OUTPUTS).coarse(_SEARCH_LEVELS)
    largest = float(numpy.abs(record.outputs - offset).max())
    gain = largest / float(numpy.abs(record.inputs).max())
    start = float(record.outputs[0])
    rows = [
        candidate(Model(sign * gain * times, tau, tau * delay, 0.0, limit, offset), start)
        for tau in _TIME_CONSTANTS * record.duration
        for delay in _DEAD_TIMES
        for times in _GAINS
        for sign in (1.0, -1.0)
        for limit in limits
    ]
    return _closest(few, rows)


def _closest(record: Record, rows: List[numpy.ndarray]) -> numpy.ndarray:
    return rows[int(numpy.argmin(squares_of(record, numpy.array(rows))))]


def _line(record: Record) -> numpy.ndarray:
    """Return the best plant with an offset: gain, start and offset are linear in the output."""
    few = record.thinned(_SEARCH_OUTPUTS).coarse(_SEARCH_LEVELS)
    rows = []
    for tau in _TIME_CONSTANTS * record.duration:
        for delay in _DEAD_TIMES:
            plants = [candidate(Model(1.0, tau, tau * delay), 0.0)]
            plants.append(candidate(Model(0.0, tau, tau * delay), 1.0))
            step, decay = responses(few, numpy.array(plants))
            columns = numpy.column_stack([step, decay, 1.0 - decay])
            gain, start, offset = numpy.linalg.lstsq(columns, few.outputs, rcond=None)[0]
            model = Model(gain, tau, tau * delay, offset=offset)
            rows.append(candidate(model, start))
    return _closest(few, rows)


def _without_friction(terms: Terms) -> List[Terms]:
    """Return the terms with one added or removed, other than friction."""
    return [terms ^ {term} for term in (DEAD_ZONE, LIMIT, OFFSET)]


def _with_friction(terms: Terms) -> List[Terms]:
    """Return the terms with friction added or removed, or swapped with the dead zone."""
    choices = [terms ^ {FRICTION}]
    if len(terms & {DEAD_ZONE, FRICTION}) == 1:
        choices.append(terms ^ {DEAD_ZONE, FRICTION})
    return choices


def _fits(record: Record, fit: Fit, choices: List[Terms]) -> List[Fit]:
    """Return the fits with each choice of terms, from the values of a fit."""
    fits = [_fit(record, _with_start(record, fit, terms), terms) for terms in choices]
    return [found for found in fits if found is not None]


def _fit(record: Record, row: numpy.ndarray, terms: Terms) -> Optional[Fit]:
    return _with_dead_zone(record, row, terms) if DEAD_ZONE in terms else Fit(record, row, terms)


def _with_start(record: Record, fit: Fit, terms: Terms) -> numpy.ndarray:
    """Return start values of the values that a fit does not have."""
    few = record.thinned(_SEARCH_OUTPUTS).coarse(_SEARCH_LEVELS)
    row = fit.row.copy()
    added = terms - fit.terms
    if LIMIT in added:
        largest = float(numpy.abs(record.outputs - row[OFFSET]).max())
        limits = [largest * share for share in _LIMITS]
        return _closest(few, [_set(row, LIMIT, limit, gain) for limit in limits for gain in _GAINS])
    if FRICTION in added:
        row[DEAD_ZONE] = row[DEAD_ZONE] if DEAD_ZONE in terms else 0.0
        largest = float(numpy.abs(record.inputs).max())
        rows = [
            _set(row, FRICTION, largest * share, gain)
            for share in _FRICTIONS
            for gain in (1.0, 1.0 / (1.0 - share))
        ]
        return _closest(few, rows)
    return row


def _set(row: numpy.ndarray, column: int, value: float, times: float) -> numpy.ndarray:
    changed = row.copy()
    changed[column] = value
    changed[GAIN] *= times
    return changed


def _with_dead_zone(record: Record, row: numpy.ndarray, terms: Terms) -> Optional[Fit]:
    """Return the best fit with a dead zone; None if the record cannot show one.

    The error is constant for all thresholds between two neighbouring input levels, so the middle
    is used.
    """
    levels = numpy.unique(numpy.abs(record.inputs))
    if len(levels) < 2:
        return None
    row = row.copy()
    if FRICTION not in terms:
        row[FRICTION] = 0.0
    best: Optional[Fit] = None
    for _ in range(4):
        tried = Fit(record, _at_best_zone(record, row, levels), terms)
        if best is not None and tried.square >= best.square:
            break
        is_settled = best is not None and tried.row[DEAD_ZONE] == best.row[DEAD_ZONE]
        best, row = tried, tried.row
        if is_settled:
            break
    return best


def _at_best_zone(record: Record, row: numpy.ndarray, levels: numpy.ndarray) -> numpy.ndarray:
    """Return a plant with its best dead zone, the other values unchanged."""
    middles = 0.5 * (levels[:-1] + levels[1:])
    low, high = 0, len(middles) - 1
    while True:
        chosen = numpy.unique(numpy.linspace(low, high, ZONES).astype(int))
        squares = squares_of_zones(record, row, middles[chosen])
        place = int(numpy.argmin(squares))
        if high - low < ZONES:
            break
        low = int(chosen[max(place - 1, 0)])
        high = int(chosen[min(place + 1, len(chosen) - 1)])
    found = row.copy()
    found[DEAD_ZONE] = middles[chosen[place]]
    return found
