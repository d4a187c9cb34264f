"""Tests of the terms that evidence chooses: offset, friction, dead zone and limit."""

import math
from typing import Optional

import numpy
import pytest
from scipy.signal import lfilter

from pid_control.identification import term_selection
from pid_control.identification.excitation import excitation
from pid_control.identification.fit import Identification, identify
from pid_control.identification.model_file import as_yaml, read_model
from pid_control.identification.record import Record, record_of
from pid_control.identification.report import as_picture, as_text
from pid_control.identification.response import GAIN, OFFSET, START, Model, candidate, responses
from pid_control.identification.step_reading import read_step
from plants import answered, autocorrelated, recorded


def heater(seed: int, noise: float = 0.2) -> Record:
    """Return the record of a heater at an ambient temperature of 20."""
    given, inputs = numpy.array([list(one) for one in excitation(0.0, 1.0, 60.0)], float).T
    times = numpy.arange(60000) * 0.001
    power = inputs[numpy.searchsorted(given, times, side="right") - 1]
    late = numpy.concatenate([numpy.zeros(100), power[:-100]])
    share = 1.0 - math.exp(-0.001)
    warmer = lfilter([0.0, 50.0 * share], [1.0, share - 1.0], late)[::40]
    noises = numpy.random.RandomState(seed).normal(0.0, noise, len(warmer))
    return record_of(given, inputs, times[::40], 20.0 + warmer + noises)


def rubbing(friction: float, seed: int, noise: float = 0.05, breakaway: float = 0.0) -> Record:
    """Return the record of a motor with Coulomb friction, integrated in small steps.

    :param breakaway: input at which the motor at rest begins to turn, if above the friction
    """
    step, gain, tau = 0.002, 10.0, 0.3
    given, inputs = numpy.array([list(one) for one in excitation(-1.0, 1.0, 30.0)], float).T
    times = numpy.arange(15000) * step
    held = inputs[numpy.maximum(numpy.searchsorted(given, times, side="right") - 1, 0)]
    speed, values = 0.0, []
    for power in held:
        values.append(speed)
        if speed == 0.0:
            starts = abs(power) > max(friction, breakaway)
            push = power - math.copysign(friction, power) if starts else 0.0
        else:
            push = power - math.copysign(friction, speed)
        faster = speed + (gain * push - speed) * step / tau
        # Friction stops the motor; it does not turn it round.
        speed = 0.0 if speed * faster < 0.0 else faster
    measured = numpy.array(values)[::10] + numpy.random.RandomState(seed).normal(0.0, noise, 1500)
    return record_of(given, inputs, times[::10], measured)


def assert_within(
    found: Identification, name: str, value: float, most: Optional[float] = None
) -> None:
    """Check that a value lies in three times its ±, which is at most this wide."""
    off = abs(getattr(found.model, name) - value)
    assert off <= 3.0 * getattr(found.uncertainty, name), (name, found)
    assert most is None or getattr(found.uncertainty, name) <= most


def test_heater_at_ambient_temperature_has_its_gain_and_no_limit() -> None:
    record = heater(1)
    found = identify(record)
    assert found.model.gain == pytest.approx(50.0, rel=0.02)
    assert found.model.limit == math.inf
    assert found.model.offset == pytest.approx(20.0, abs=0.2)
    assert_within(found, "gain", 50.0, 1.0)
    assert_within(found, "offset", 20.0, 0.2)
    assert found.test.independent > 1200.0  # of 1500 outputs, all are used
    text = as_text(record, found, read_step(record))
    assert "\noffset      20" in text
    assert "± holds in 95 of 100" in text
    assert "offset 20" in as_picture(record, found)
    model = as_yaml(found, "a record")
    assert "# offset 20" in model
    assert read_model(model).gain == pytest.approx(found.model.gain, rel=1e-5)


def test_search_begins_near_a_plant_that_coasts_to_its_offset() -> None:
    plant = Model(-5.0, 1.0, offset=20.0)
    record = answered([[0.0, 0.0], [4.0, 1.0], [8.0, -1.0]], plant, 12.0, outputs=300)
    outputs = responses(record, candidate(plant, 27.0)[None, :])[0]
    record = record._replace(outputs=outputs)
    line = term_selection._line(record)
    assert (line[GAIN], line[START], line[OFFSET]) == pytest.approx((-5.0, 27.0, 20.0), rel=0.2)
    assert term_selection._begin(record, [math.inf], 0.0)[START] == outputs[0] == 27.0


@pytest.mark.extended
def test_coulomb_friction_does_not_shift_the_gain() -> None:
    found = identify(rubbing(0.15, 1))
    assert found.model.gain == pytest.approx(10.0, rel=0.02)
    assert found.model.friction == pytest.approx(0.15, abs=0.01)
    assert found.model.limit == math.inf
    assert_within(found, "friction", 0.15, 0.01)


@pytest.mark.extended
def test_identify_threshold_dead_zone_is_not_taken_for_friction() -> None:
    found = identify(recorded(Model(10.0, 0.3, 0.0, 0.15), 0.01))
    assert found.model.dead_zone == pytest.approx(0.15, abs=0.02)
    assert found.model.friction == 0.0 and found.model.offset == 0.0


def test_dead_zone_lies_between_levels_of_either_sign() -> None:
    levels = [0.1, -0.2, 0.4, -0.5, 0.1, -0.7, 0.8, -0.2, 1.0, -0.5]
    changes = [[5.0 * index, level] for index, level in enumerate(levels)]
    found = identify(answered(changes, Model(10.0, 0.5, 0.1, 0.15), 50.0, 0.01, outputs=500))
    assert 0.1 <= found.model.dead_zone <= 0.2


@pytest.mark.extended
def test_autocorrelated_noise_invents_no_limit_and_covers_the_dead_zone() -> None:
    plant = Model(10.0, 0.3, 0.02, 0.15)
    inside, limits = 0, 0
    for seed in range(5):
        record = autocorrelated(recorded(plant, outputs=1500), 0.02, 0.9, seed)
        found = identify(record)
        limits += math.isfinite(found.model.limit)
        inside += abs(found.model.dead_zone - 0.15) <= found.uncertainty.dead_zone
    assert limits == 0
    assert inside >= 4


def test_identify_second_order_plant_withdraws_the_uncertainty() -> None:
    record = recorded(Model(10.0, 0.3))
    lag = numpy.exp(-record.interval / 0.15)
    slower = lfilter([1.0 - lag], [1.0, -lag], record.outputs)
    noises = numpy.random.RandomState(1).normal(0.0, 0.05, len(slower))
    found = identify(record._replace(outputs=slower + noises))
    assert found.test.follows_input and not found.test.fits
    assert "± does not hold in 95 of 100: the residual follows the input" in as_text(
        record, found, None
    )
    assert "# +- does not hold in 95 of 100" in as_yaml(found, "a record")
    assert "residual: ± does not hold" in as_picture(record, found)
