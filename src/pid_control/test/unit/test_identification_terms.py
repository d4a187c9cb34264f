"""Tests of the terms that evidence chooses: offset, friction, dead zone and limit."""

import math
from typing import Any, List, Optional
from unittest import mock

import numpy
import pytest
from scipy.signal import lfilter

from pid_control.identification import term_selection
from pid_control.identification.excitation import excitation
from pid_control.identification.fit import Identification, identify
from pid_control.identification.model_file import as_yaml, read_model
from pid_control.identification.record import Record, record_of
from pid_control.identification.report import as_picture, as_text
from pid_control.identification.least_squares import Fit
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
    candidate,
    responses,
)
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


def part_of(record: Record, every: int) -> Record:
    return record._replace(times=record.times[::every], outputs=record.outputs[::every])


def widths_of(
    record: Record, found: Identification, columns: List[int], alike: float
) -> numpy.ndarray:
    """Return 1.96 standard deviations of each value, from the plant's own slopes.

    :param columns: the values that were fitted
    :param alike: correlation of the noise of neighbouring outputs
    """
    row = candidate(found.model, float(record.outputs[0]))
    slopes = []
    for column in columns:
        step = numpy.zeros(8)
        step[column] = 1e-5 * (abs(row[column]) or 1.0)
        ends = responses(record, numpy.array([row + step, row - step]))
        slopes.append((ends[0] - ends[1]) / (2.0 * step[column]))
    jacobian = numpy.array(slopes).T
    inverse = numpy.linalg.inv(jacobian.T @ jacobian)
    count, places = len(record.times), numpy.arange(len(record.times))
    noise = alike ** numpy.abs(places[:, None] - places)
    variance = found.residual**2 * count / (count - len(columns))
    covariance = inverse @ jacobian.T @ noise @ jacobian @ inverse
    widths: numpy.ndarray = 1.96 * numpy.sqrt(variance * numpy.diag(covariance))
    return widths


#: Records, the optional terms of their models, and factors of outputs, inputs and times.
UNITS = {
    "limited": (
        recorded(Model(10.0, 0.3, 0.05, 0.15, 6.0), 0.01, outputs=500),
        (LIMIT,),
        (-100.0, 10.0, 0.1),
    ),
    "heater": (part_of(heater(1), 3), (OFFSET,), (-0.01, 0.1, 10.0)),
    "rubbing": (part_of(rubbing(0.15, 1), 5), (FRICTION,), (-100.0, -10.0, 0.1)),
}


@pytest.mark.parametrize("name", UNITS)
def test_identification_does_not_depend_on_units_or_signs(name: str) -> None:
    """Neither the values nor their uncertainty, which is that of the slopes and of the noise."""
    record, terms, (up, ahead, slow) = UNITS[name]
    found = identify(record)
    assert (found.test.fits, found.test.is_white) == (True, True)
    columns = [GAIN, TIME_CONSTANT, DEAD_TIME, START, *terms]
    count = len(record.times)
    alike = (count - found.test.independent) / (count + found.test.independent)
    assert alike < 0.15
    widths = widths_of(record, found, columns, alike)
    fields = [column - (column > START) for column in columns if column != START]
    stated = [found.uncertainty[field] for field in fields]
    assert stated == pytest.approx(numpy.delete(widths, 3), rel=0.05)
    other = identify(
        Record(
            slow * record.changed_at,
            ahead * record.inputs,
            slow * record.times,
            up * record.outputs,
        )
    )
    factors = (up / ahead, slow, slow, abs(ahead), abs(up), up, abs(ahead))
    expected = numpy.multiply(found.model, factors)
    assert other.model == pytest.approx(expected, rel=1e-4, abs=1e-5)
    assert other.uncertainty == pytest.approx(
        numpy.abs(numpy.multiply(found.uncertainty, factors)), rel=1e-3
    )
    assert (other.explained, other.residual) == pytest.approx(
        (found.explained, abs(up) * found.residual), rel=1e-6
    )


def test_uncertainty_of_autocorrelated_noise_is_that_of_its_covariance() -> None:
    record = autocorrelated(recorded(Model(2.0, 1.0), outputs=1000), 0.02, 0.8, 1)
    found = identify(record)
    widths = widths_of(record, found, [GAIN, TIME_CONSTANT, DEAD_TIME, START], 0.8)
    assert found.uncertainty[:3] == pytest.approx(widths[:3], rel=0.15)
    assert (found.test.is_white, found.test.is_noise, found.test.fits) == (False, True, True)


@pytest.mark.parametrize(
    "late, limit, duration", [(0.3, 0.5, 12.0), (0.6, 0.5, 12.0), (0.6, 0.3, 6.0)]
)
def test_input_may_be_recorded_half_a_second_late_or_a_twentieth(
    late: float, limit: float, duration: float
) -> None:
    record = answered([(0.0, 0.0), (2.0, 0.5)], Model(13.1, 0.4), duration, outputs=400)
    record = record._replace(changed_at=record.changed_at + numpy.array([0.0, late]))
    found = Fit(record, candidate(Model(13.0, 0.4), 0.0), frozenset())
    assert found.row[DEAD_TIME] == pytest.approx(-min(late, limit), abs=1e-3)


def steps_of(plant: Model, start: float, largest: float, outputs: int = 400) -> Record:
    """Return the record of a plant whose inputs are fortieths of the largest, for 40 s."""
    levels = [0.25, 1.0, -0.1, 0.75, 0.0, -0.2, 0.5, 0.0]
    changes = [[5.0 * number, largest * level] for number, level in enumerate(levels)]
    record = answered(changes, plant, 40.0, outputs=outputs)
    return record._replace(outputs=responses(record, candidate(plant, start)[None, :])[0])


@pytest.mark.parametrize("times, delay, tau", [(2.0, 0.4, 3), (-4.0, 1.2, 4), (1.4, 0.0, 5)])
def test_search_finds_a_plant_that_it_tries(times: float, delay: float, tau: int) -> None:
    """Gains are multiples of the one that just reaches the limit."""
    constant = 40.0 * 0.5e-3 * 1000.0 ** (tau / 9.0)
    plant = Model(times * 6.0 / 8.0, constant, constant * delay, 0.0, 6.0, -20.0)
    for largest in (8.0, -8.0):
        record = steps_of(plant, -20.0, largest)
        assert numpy.abs(record.outputs + 20.0).max() == pytest.approx(6.0)
        row = term_selection._begin(record, [3.0, 6.0, math.inf], -20.0)
        assert row == pytest.approx(candidate(plant, record.outputs[0]))
    free = plant._replace(limit=math.inf)
    record = steps_of(free, -27.0, 8.0)
    assert term_selection._line(record) == pytest.approx(candidate(free, -27.0), abs=1e-6)


def test_added_limit_and_friction_begin_with_a_larger_gain() -> None:
    plant = Model(-3.0, 1.0, 0.4, 0.0, 6.0, -20.0)
    record = steps_of(plant, -20.0, 4.0)
    record.outputs[3] = -20.0 - 6.0 / 0.85  # noise
    fit = Fit(record, candidate(plant, -20.0), frozenset({OFFSET}))
    fit.row = candidate(plant._replace(gain=-1.5, limit=math.inf), -20.0)
    row = term_selection._with_start(record, fit, frozenset({OFFSET, LIMIT}))
    assert row == pytest.approx(candidate(plant, -20.0))
    plant = Model(-3.0, 1.0, 0.4, friction=0.4)
    record = steps_of(plant, 0.0, -4.0)
    fit.row = candidate(plant._replace(gain=-2.7, friction=0.0, dead_zone=0.5), 0.0)
    fit.terms = frozenset({DEAD_ZONE})
    row = term_selection._with_start(record, fit, frozenset({FRICTION}))
    assert row == pytest.approx(candidate(plant, 0.0))
    row = term_selection._with_start(record, fit, frozenset({FRICTION, DEAD_ZONE}))
    assert row[4] == 0.5


def test_first_fits_find_the_limit_of_either_sign() -> None:
    for gain in (3.0, -3.0):
        for offset in (0.0, -50.0):
            record = answered(
                [[0.0, 0.0], [2.0, 1.0], [8.0, 0.25]], Model(gain, 1.0, 0.2, 0.0, 2.0, offset), 16.0
            )
            terms = frozenset({LIMIT, OFFSET} if offset else {LIMIT})
            with mock.patch.object(term_selection, "_begin", wraps=term_selection._begin) as begin:
                best = min(term_selection._first_fits(record), key=lambda fit: fit.square)
            if not offset:  # the limit may be the largest output, or noise may be beyond it
                tried = [call[0][1] for call in begin.call_args_list[:2]]
                assert tried == [[math.inf], pytest.approx([2.0, 1.7, 1.4], rel=1e-3)]
            assert terms <= best.terms
            assert best.row[LIMIT] == pytest.approx(2.0, rel=1e-3)


def test_terms_are_added_and_removed_one_by_one() -> None:
    two = frozenset({LIMIT, FRICTION})
    assert term_selection._without_friction(two) == [
        {DEAD_ZONE, LIMIT, FRICTION},
        {FRICTION},
        {LIMIT, OFFSET, FRICTION},
    ]
    assert term_selection._with_friction(two) == [{LIMIT}, {LIMIT, DEAD_ZONE}]
    assert term_selection._with_friction(frozenset({DEAD_ZONE})) == [
        {DEAD_ZONE, FRICTION},
        {FRICTION},
    ]
    assert term_selection._with_friction(frozenset()) == [{FRICTION}]


@pytest.mark.parametrize(
    "per_independent, square, is_worth",
    [
        # 1000 ln(1 / square) against ln 1000 + 4, and 100 ln(1 / square) against ln 100 + 4.
        (1.0, 0.9890, True),
        (1.0, 0.9893, False),
        (10.0, 0.917, True),
        (10.0, 0.918, False),
    ],
)
def test_term_must_be_worth_its_penalty(
    per_independent: float, square: float, is_worth: bool
) -> None:
    blank = recorded(Model(2.0, 1.0), outputs=1000)
    criterion = term_selection._InformationCriterion(blank)

    def best_is_second(first: float, second: float, worse: float, *terms: int) -> bool:
        """Compare a fit without and one with a term by their squared errors."""
        fits: Any = [
            mock.Mock(square=first, per_independent=worse, terms=frozenset()),
            mock.Mock(square=second, per_independent=per_independent, terms=frozenset(terms)),
        ]
        return criterion.best(fits) is fits[1]

    assert best_is_second(1.0, square, 50.0, LIMIT) is is_worth
    # The noise is that of the closest fit so far, whatever is compared.
    per_independent, was = 77.0, per_independent
    assert best_is_second(1.1, 1.1 * square, 50.0, LIMIT) is is_worth
    assert not best_is_second(1.0, 1.0, 50.0)
    assert best_is_second(1.0, 0.999, 50.0)
    # A residual of rounding does not count.
    per_independent = was
    assert not best_is_second(1e-12, 0.0, 50.0, LIMIT)


@pytest.mark.parametrize("zone", [0.0625, 0.301, 0.9991])
def test_dead_zone_among_many_levels_lies_between_its_neighbours(zone: float) -> None:
    plant = Model(-10.0, 0.5, 0.1, zone)
    inputs = [0.001 * number * (-1.0) ** number for number in range(1001)]
    record = answered([[0.5 * n, one] for n, one in enumerate(inputs)], plant, 501.0, outputs=1500)
    row = candidate(plant._replace(dead_zone=0.5), 0.0)
    found = term_selection._at_best_zone(record, row, numpy.arange(1001) * 0.001)
    assert found[4] == pytest.approx(math.floor(1000.0 * zone) * 0.001 + 0.0005)


def test_dead_zone_needs_two_levels() -> None:
    record = answered([[0.0, 1.0], [2.0, -1.0]], Model(2.0, 1.0), 9.0)
    terms = frozenset({DEAD_ZONE})
    row = candidate(Model(2.0, 1.0), 0.0)
    assert term_selection._with_dead_zone(record, row, terms) is None
    record = answered([[0.0, 0.5], [2.0, -1.0]], Model(2.0, 1.0, 0.0, 0.6), 9.0)
    found = term_selection._with_dead_zone(record, row, terms)
    assert found is not None and found.row[DEAD_ZONE] == 0.75


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
    assert (found.model.limit, found.model.dead_zone, found.model.friction) == (math.inf, 0.0, 0.0)
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
    assert (found.model.dead_zone, found.uncertainty.dead_zone) == pytest.approx((0.15, 0.05))


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
