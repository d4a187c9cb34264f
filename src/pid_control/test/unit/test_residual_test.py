"""Tests of what the residual of a fit shows."""

from typing import Tuple

import numpy
import pytest
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


def test_examine_few_independent_outputs_cannot_tell() -> None:
    for alike in (0.975, 0.999):
        found = examine(*record_and_noise(1, alike), MODEL)
        assert not found.can_tell and not found.fits
