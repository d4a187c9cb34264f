"""Tests of what the residual of a fit shows."""

import math
from typing import Tuple

import numpy
import pytest
from scipy import stats
from scipy.signal import lfilter

from pid_control.identification.record import Record, record_of
from pid_control.identification.residual_test import examine
from pid_control.identification.response import Model

MODEL = Model(1.0, 1.0)
TIMES = numpy.arange(2000) * 0.1


def record_and_noise(seed: int, alike: float) -> Tuple[Record, numpy.ndarray]:
    """Return a record with an input of either sign, and AR(1) noise that ignores it."""
    draws = numpy.random.RandomState(seed)
    inputs = draws.choice([-1.0, -0.5, 0.5, 1.0], 400)
    record = record_of(TIMES[::5], inputs, TIMES, TIMES)
    return record, lfilter([1.0], [1.0, -alike], draws.normal(0.0, 1.0, len(TIMES)))


@pytest.mark.parametrize("alike", [0.0, 0.95])
def test_examine_noise_of_any_correlation_fits(alike: float) -> None:
    for seed in range(5):
        found = examine(*record_and_noise(seed, alike), MODEL)
        assert found.fits and found.is_white == (alike == 0.0), (seed, found)


@pytest.mark.parametrize("power, dead_time", [(1, 0.0), (2, 0.0), (1, 20.0)])
def test_examine_residual_that_depends_on_the_input_does_not_fit(
    power: int, dead_time: float
) -> None:
    """Also on its square, and on an input of long ago; whatever the unit of the input."""
    record, noise = record_and_noise(1, 0.0)
    held = numpy.searchsorted(record.changed_at, TIMES - dead_time, side="right") - 1
    acting = record.inputs[numpy.maximum(held, 0)] ** power
    for unit in (1.0, 1e-4, 1e4):
        scaled = record._replace(inputs=unit * record.inputs)
        found = examine(scaled, noise + 0.5 * acting, MODEL._replace(dead_time=dead_time))
        assert found.follows_input and not found.fits, unit
        if power == 1:  # the input is held for five outputs, which are not independent then
            assert found.independent < 1800.0


def test_examine_alarms_once_in_a_thousand_records() -> None:
    """The share of the input in the residual at which it follows, by an F test of 16 values."""
    record, noise = record_and_noise(5, 0.0)
    noise, model = noise - noise.mean(), Model(1.0, 2.0, 7.0)
    columns = []
    for lag in (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0):
        acting = TIMES - 7.0 - 2.0 * lag
        held = numpy.searchsorted(record.changed_at, acting, side="right") - 1
        inputs = record.inputs[numpy.maximum(held, 0)]
        columns += [inputs, inputs**2]
    past = numpy.column_stack(columns) - numpy.mean(columns, axis=1)
    axes = numpy.linalg.qr(past)[0]
    rest = noise - axes @ (axes.T @ noise)
    edge = 16.0 * stats.f.isf(1e-3, 16, 1984) / 1984.0 * float(rest @ rest)
    for column in range(16):
        for factor, follows in ((0.998, False), (1.002, True)):
            found = examine(record, rest + math.sqrt(factor * edge) * axes[:, column], model)
            assert found.follows_input is follows, (column, factor)


def test_examine_whiteness_is_that_of_20_lags() -> None:
    record, noise = record_and_noise(3, 0.0)
    for lag in (1, 2, 19, 20, 21):
        wave = noise + 0.25 * numpy.roll(noise, lag)
        found = examine(record, wave, MODEL)
        # AR(1) noise explains the first lag, and the next ones only as its powers.
        assert (found.is_white, found.is_noise) == (lag > 20, lag in (1, 21)), (lag, found)


def test_examine_residual_of_rounding_fits() -> None:
    record, noise = record_and_noise(1, 0.95)
    span = record.span * math.sqrt(len(TIMES)) / float(numpy.linalg.norm(noise))
    assert examine(record, 0.9e-6 * span * noise, MODEL) == (True, True, False, True, 2000.0)
    assert examine(record, 1.1e-6 * span * noise, MODEL).is_white is False


def test_examine_few_independent_outputs_cannot_tell() -> None:
    for alike in (0.975, 0.999):
        found = examine(*record_and_noise(1, alike), MODEL)
        assert (found.can_tell, found.follows_input, found.fits) == (False, False, False)
    # The 14 independent ones of 16 values need 28 independent outputs.
    for count, can_tell in ((27, False), (28, True)):
        record, noise = record_and_noise(1, 0.0)
        few = record._replace(times=TIMES[::5][:count], outputs=TIMES[::5][:count])
        rough = 0.3 * noise[:count] + numpy.resize([1.0, -1.0], count)
        assert examine(few, rough, MODEL).can_tell is can_tell
