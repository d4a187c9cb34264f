"""Test of a residual: whether the model explains the whole effect of the input."""

from typing import NamedTuple

import numpy
from scipy.special import chdtrc, fdtrc

from pid_control.identification.noise import covariance_of_sums, outputs_per_independent_one
from pid_control.identification.record import Record
from pid_control.identification.response import Model

#: Probability of a false alarm.
_ALARM = 1e-3
#: Lags of the residual [outputs], and of the input [T].
_WHITE_LAGS = 20
_INPUT_LAGS = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
#: Residual that counts as rounding, as a share of the outputs' range.
_ROUNDING = 1e-6
#: Fewest independent outputs for each value of the test.
_FEWEST = 2.0


class ResidualTest(NamedTuple):
    """Result of the test of a residual.

    :ivar is_white: whether the residual is like white noise
    :ivar is_noise: whether it is like white noise, or AR(1) noise of any correlation
    :ivar follows_input: whether it depends on the input: the model lacks a term
    :ivar can_tell: whether the record has enough independent outputs to see that
    :ivar independent: number of independent outputs
    """

    is_white: bool
    is_noise: bool
    follows_input: bool
    can_tell: bool
    independent: float

    @property
    def fits(self) -> bool:
        """Whether the residual is noise that does not depend on the input."""
        return self.is_noise and self.can_tell and not self.follows_input


def examine(record: Record, errors: numpy.ndarray, model: Model) -> ResidualTest:
    """Examine a residual by its autocorrelation and its cross-correlation with the input.

    Whiteness is the statistic N (r1^2 + ... + rM^2) of the autocorrelations, and the
    cross-correlation with past inputs has the variance that the residual's own autocorrelation
    gives it (Ljung: System Identification, 2nd edition, section 16.6); several lags are tested
    together as in Soderstrom and Stoica: System Identification, 1989, chapter 11. The squares of
    the inputs are included, to detect nonlinearity (Billings and Voon: Correlation based model
    validity tests for non-linear models, International Journal of Control 44, 1986).

    :param record: the record of the fit
    :param errors: the residual
    :param model: the model
    """
    count = len(errors)
    if float(numpy.sqrt(numpy.mean(errors**2))) <= _ROUNDING * record.span:
        return ResidualTest(True, True, False, True, float(count))
    errors = errors - errors.mean()
    alike = float(errors[:-1] @ errors[1:]) / float(errors @ errors)
    columns = _past_inputs(record, model)
    rest = errors - columns @ (columns.T @ errors)
    per_independent = outputs_per_independent_one(rest)
    independent = count / per_independent
    values = columns.shape[1]
    spare = independent - values
    follows = False
    if spare > 0.0:
        products = columns.T @ errors
        covariance = covariance_of_sums(columns, per_independent) * float(rest @ rest) / count
        covariance *= independent / spare
        statistic = float(products @ numpy.linalg.solve(covariance, products)) / values
        follows = bool(fdtrc(values, spare, statistic) < _ALARM)
    return ResidualTest(
        is_white=_is_white(errors),
        is_noise=_is_white(errors[1:] - alike * errors[:-1]),
        follows_input=follows,
        can_tell=independent >= _FEWEST * values,
        independent=count / outputs_per_independent_one(errors),
    )


def _is_white(errors: numpy.ndarray) -> bool:
    count, lags = len(errors), min(_WHITE_LAGS, len(errors) // 4)
    square = float(errors @ errors)
    alike = [float(errors[:-lag] @ errors[lag:]) / square for lag in range(1, lags + 1)]
    return bool(chdtrc(lags, count * float(numpy.sum(numpy.square(alike)))) >= _ALARM)


def _past_inputs(record: Record, model: Model) -> numpy.ndarray:
    """Return orthonormal columns that span the earlier inputs and their squares."""
    columns = []
    for lag in _INPUT_LAGS:
        due = record.times - model.dead_time - lag * model.time_constant
        held = numpy.searchsorted(record.changed_at, due, side="right") - 1
        inputs = record.inputs[numpy.maximum(held, 0)]
        columns += [inputs, inputs**2]
    stacked = numpy.column_stack(columns)
    stacked = stacked - stacked.mean(axis=0)
    # Scaled, so that the unit of the input does not decide which of them count.
    lengths = numpy.linalg.norm(stacked, axis=0)
    stacked = stacked / numpy.where(lengths > 0.0, lengths, 1.0)
    axes, singular, _ = numpy.linalg.svd(stacked, full_matrices=False)
    spanned: numpy.ndarray = axes[:, singular > 1e-3 * singular[0]]
    return spanned
