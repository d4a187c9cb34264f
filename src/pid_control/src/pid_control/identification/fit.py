"""Identification of a plant from a record, with the uncertainty of each value."""

import math
from typing import NamedTuple

import numpy

from pid_control.identification.record import IdentificationError, Record
from pid_control.identification.residual_test import ResidualTest, examine
from pid_control.identification.response import (
    DEAD_TIME,
    DEAD_ZONE,
    FRICTION,
    GAIN,
    LIMIT,
    OFFSET,
    TIME_CONSTANT,
    Model,
    responses,
)
from pid_control.identification.term_selection import best_fit

#: Least share of the outputs' variance to explain, and largest relative uncertainty of K and T.
_LEAST_EXPLAINED, _MAX_UNCERTAINTY = 0.5, 0.5


class Identification(NamedTuple):
    """Result of an identification.

    :ivar model: the plant
    :ivar uncertainty: half width of the 95 % confidence interval of each field of the model;
        infinite if the record does not determine the value
    :ivar fitted: the model's outputs at the times of the record
    :ivar residual: root mean square of the record's outputs minus the fitted ones
    :ivar explained: share of the outputs' variance that the model explains
    :ivar test: whether the residual is noise, on which the uncertainty relies
    """

    model: Model
    uncertainty: Model
    fitted: numpy.ndarray
    residual: float
    explained: float
    test: ResidualTest


def identify(record: Record) -> Identification:
    """Identify K, T and dead time, and dead zone, limit, offset and friction if present.

    Those four are part of the model only if they improve the Bayesian information criterion, see
    :mod:`.term_selection`; otherwise they are 0, and the limit infinite. For the uncertainty see
    :meth:`.Fit.uncertainty`.

    :param record: a record of the plant
    :raises IdentificationError: if the record does not determine the plant
    """
    fit = best_fit(record)
    row = fit.row
    fitted = responses(record, row[None, :])[0]
    errors = record.outputs - fitted
    explained = 1.0 - float(numpy.var(errors) / numpy.var(record.outputs))
    if explained < _LEAST_EXPLAINED:
        raise IdentificationError(
            "the output does not follow the input: a first-order plant explains "
            f"{max(100.0 * explained, 0.0):.0f} % of it"
        )
    uncertainty = fit.uncertainty()
    columns = (GAIN, TIME_CONSTANT, DEAD_TIME, DEAD_ZONE, LIMIT, OFFSET, FRICTION)
    model = Model(*(float(row[column]) for column in columns))
    _check_uncertainty(record, model, uncertainty)
    residual = math.sqrt(float(numpy.mean(errors**2)))
    test = examine(fit.record, fit.errors, model)
    return Identification(model, uncertainty, fitted, residual, explained, test)


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
