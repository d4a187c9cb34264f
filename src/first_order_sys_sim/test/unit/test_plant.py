"""The sampled plant against closed forms in 50 digits, computed apart from it."""

import math
from decimal import Decimal, getcontext
from typing import List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from first_order_sys_sim.first_order_plant import EULER, FirstOrderPlant, PlantSettings
from first_order_sys_sim.sampled_plant import SampledPlant

getcontext().prec = 50

#: The course's values, with an inactive limit and dead zone.
COURSE = PlantSettings(gain=13.2, time_constant=0.05)
SAMPLE_TIME = 0.02
LIMITED = COURSE._replace(max_output=13.0, min_input=0.2)

gains = st.floats(-20.0, 20.0)
time_constants = st.floats(1e-3, 1e3)
sample_times = st.floats(1e-3, 10.0)
inputs = st.floats(-2.0, 2.0)
outputs = st.floats(-20.0, 20.0)


def decay(start: float, target: float, seconds: float, time_constant: float) -> float:
    """Return the state after some time [s], by the textbook's formula."""
    rest = (-Decimal(seconds) / Decimal(time_constant)).exp()
    return float(Decimal(target) + (Decimal(start) - Decimal(target)) * rest)


def step_response(settings: PlantSettings, seconds: float, value: float = 1.0) -> float:
    """Return the output some time after a step from rest [s]."""
    return decay(0.0, settings.gain * value, seconds, settings.time_constant)


@given(gains, time_constants, sample_times, inputs, st.integers(1, 100), st.floats(1.0, 1000.0))
def test_step_is_exact_at_any_sample_time_and_any_moment(
    gain: float, tau: float, sample_time: float, value: float, samples: int, rate: float
) -> None:
    plant = SampledPlant(PlantSettings(gain, tau), sample_time)
    plant.set_input(0.0, value)
    end = samples * sample_time
    moments = [end * index / 200 for index in range(200)] + [n / rate for n in range(50)]
    for moment in sorted(moments):
        exact = step_response(PlantSettings(gain, tau), moment, value)
        assert plant.output(moment) == pytest.approx(exact, rel=0.0, abs=1e-12)


@given(
    time_constants,
    st.floats(1e-3, 1.0),
    st.lists(inputs, min_size=1, max_size=30),
    outputs,
)
def test_each_held_input_is_answered_exactly(
    tau: float, sample_time: float, values: List[float], start: float
) -> None:
    plant = SampledPlant(PlantSettings(13.2, tau), sample_time, start)
    expected = start
    for number, value in enumerate(values):
        plant.set_input(number * sample_time, value)
        expected = decay(expected, 13.2 * value, sample_time, tau)
        got = plant.output((number + 1) * sample_time)
        assert got == pytest.approx(expected, rel=0.0, abs=2e-12)


@given(st.lists(st.tuples(st.floats(0.0, 1.0), inputs), max_size=10), st.floats(0.0, 1.0))
def test_it_does_not_matter_how_often_the_output_is_looked_at(
    events: List[Tuple[float, float]], end: float
) -> None:
    looked_at, left_alone = SampledPlant(LIMITED, SAMPLE_TIME), SampledPlant(LIMITED, SAMPLE_TIME)
    moment = 0.0
    for wait, value in events:
        for part in range(10):
            looked_at.output(moment + wait * part / 10)
        moment += wait
        looked_at.set_input(moment, value)
        left_alone.set_input(moment, value)
    assert looked_at.output(moment + end) == pytest.approx(
        left_alone.output(moment + end), abs=1e-9
    )


def test_input_is_found_by_the_next_sample_only_and_then_held() -> None:
    plant = SampledPlant(COURSE, SAMPLE_TIME)
    plant.set_input(0.021, 1.0)
    assert plant.output(0.04) == 0.0
    plant.set_input(0.045, 0.0)
    assert plant.output(0.05) == pytest.approx(step_response(COURSE, 0.01), abs=1e-12)
    peak = step_response(COURSE, 0.02)
    assert plant.output(0.06) == pytest.approx(peak, abs=1e-12)
    assert plant.output(0.07) == pytest.approx(decay(peak, 0.0, 0.01, 0.05), abs=1e-12)


def test_sample_uses_simultaneous_input() -> None:
    plant = SampledPlant(COURSE, SAMPLE_TIME)
    for number in range(1, 2000):
        moment = 3 * number / 150  # now above, now below number * 0.02
        value = float(number % 2)
        before = plant.output(moment)
        plant.set_input(moment, value)
        after = decay(before, 13.2 * value, 0.01, 0.05)
        assert plant.output(moment + 0.01) == pytest.approx(after, abs=1e-9)


@given(st.lists(st.tuples(st.floats(0.0, 0.2), st.floats(-1e3, 1e3)), max_size=30))
def test_output_never_passes_the_limit(events: List[Tuple[float, float]]) -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME, output=20.0)
    moment = 0.0
    for wait, value in events:
        assert abs(plant.output(moment)) <= 13.0
        plant.set_input(moment, value)
        moment += wait


@given(st.floats(1.0, 1e4), st.floats(1.0, 1e3))
def test_output_leaves_limit_without_windup(seconds: float, value: float) -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME)
    plant.set_input(0.0, value)
    turn = math.ceil(seconds / 0.02) * 0.02
    assert plant.output(turn) == 13.0
    plant.set_input(turn, 0.5)
    assert plant.output(turn + 0.001) == pytest.approx(decay(13.0, 6.6, 0.001, 0.05), abs=1e-6)


def test_limit_is_reached_when_the_free_response_reaches_it() -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME)
    plant.set_input(0.0, 1.5)
    reached = -0.05 * math.log(1.0 - 13.0 / (13.2 * 1.5))
    assert plant.output(reached - 1e-6) < 13.0
    assert plant.output(reached - 1e-6) == pytest.approx(13.0, abs=1e-3)
    assert plant.output(reached + 1e-6) == 13.0


@pytest.mark.parametrize("value", [0.2, -0.2, 0.1, 0.0])
def test_dead_zone_ends_with_its_bound(value: float) -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME)
    plant.set_input(0.0, value)
    assert plant.output(1.0) == 0.0


@pytest.mark.parametrize("value", [0.201, -0.201, 0.5])
def test_input_beyond_the_dead_zone_acts_in_full(value: float) -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME)
    plant.set_input(0.0, value)
    assert plant.output(10.0) == pytest.approx(13.2 * value, abs=1e-12)


@given(
    st.lists(
        st.tuples(
            st.floats(0.0, 0.1),
            st.builds(
                PlantSettings,
                gains,
                time_constants,
                st.just(13.0),
                st.floats(0.0, 0.5),
                st.sampled_from(["exact", "euler"]),
            ),
            sample_times,
            inputs,
        ),
        max_size=20,
    )
)
def test_no_change_makes_the_output_jump(
    changes: List[Tuple[float, PlantSettings, float, float]],
) -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME)
    moment = 0.0
    for wait, settings, sample_time, value in changes:
        moment += wait
        before = plant.output(moment)
        plant.change(moment, settings, sample_time)
        assert plant.output(moment) == before
        plant.set_input(moment, value)


def test_output_continues_after_change_of_gain_and_time_constant() -> None:
    plant = SampledPlant(COURSE, SAMPLE_TIME)
    plant.set_input(0.0, 1.0)
    before = plant.output(0.03)
    plant.change(0.03, COURSE._replace(gain=5.0, time_constant=0.3), SAMPLE_TIME)
    assert plant.output(0.04) == pytest.approx(decay(before, 5.0, 0.01, 0.3), abs=1e-12)


def test_new_sample_time_counts_from_the_last_sample() -> None:
    plant = SampledPlant(COURSE, SAMPLE_TIME)
    plant.change(0.03, COURSE, 0.05)  # sampled at 0.02, next at 0.07
    plant.set_input(0.03, 1.0)
    assert plant.output(0.07) == 0.0
    assert plant.output(0.08) == pytest.approx(step_response(COURSE, 0.01), abs=1e-12)


def test_sample_overdue_by_new_sample_time_is_taken_immediately() -> None:
    plant = SampledPlant(COURSE, 1.0)
    plant.output(0.0)
    plant.set_input(0.5, 1.0)
    plant.change(0.5, COURSE, SAMPLE_TIME)
    assert plant.output(0.5) == 0.0
    assert plant.output(0.51) == pytest.approx(step_response(COURSE, 0.01), abs=1e-12)


def test_lower_limit_applies_immediately_and_higher_one_without_jump() -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME)
    plant.set_input(0.0, 1.5)
    plant.output(1.0)
    plant.change(1.0, LIMITED._replace(max_output=5.0), SAMPLE_TIME)
    assert plant.output(1.0) == 5.0
    plant.change(2.0, LIMITED, SAMPLE_TIME)
    assert plant.output(2.0) == 5.0
    assert 5.0 < plant.output(2.001) < 6.0


def test_it_can_be_put_into_a_state() -> None:
    plant = SampledPlant(LIMITED, SAMPLE_TIME, output=1.0)
    assert plant.output(0.0) == 1.0
    plant.set_output(0.5, -2.0)
    assert plant.output(0.5) == -2.0
    assert plant.output(0.6) == pytest.approx(decay(-2.0, 0.0, 0.1, 0.05), abs=1e-12)


def test_state_beyond_the_limit_leaves_it_at_once() -> None:
    limited = PlantSettings(2.0, 1.0, 3.0)
    lowered, placed = FirstOrderPlant(PlantSettings(2.0, 1.0), 9.0), FirstOrderPlant(limited)
    lowered.change(0.0, limited)
    placed.set_output(0.0, -9.0)
    for plant, start in ((FirstOrderPlant(limited, 9.0), 3.0), (lowered, 3.0), (placed, -3.0)):
        assert plant.output(0.0) == start
        assert plant.output(1.0) == pytest.approx(start * math.exp(-1.0))


def test_decreasing_time_is_ignored() -> None:
    plant = SampledPlant(COURSE, SAMPLE_TIME)
    plant.set_input(0.0, 1.0)
    later = plant.output(0.1)
    assert plant.output(0.05) == later
    plant.output(0.11)
    plant.set_input(0.0, 0.0)
    peak = plant.output(0.12)
    assert peak == pytest.approx(step_response(COURSE, 0.12), abs=1e-12)
    assert plant.output(0.13) < peak


def test_euler_is_off_by_nine_percent_of_the_gain_at_the_courses_values() -> None:
    plant = SampledPlant(COURSE._replace(method=EULER), SAMPLE_TIME)
    plant.set_input(0.0, 1.0)
    numbers = range(1, 50)
    by_slides, expected = 0.0, []
    for _ in numbers:
        by_slides += 0.02 / 0.05 * (13.2 - by_slides)
        expected.append(by_slides)
    got = [plant.output(number * 0.02) for number in numbers]
    assert got == pytest.approx(expected, abs=1e-12)
    errors = [y - step_response(COURSE, n * 0.02) for n, y in zip(numbers, got)]
    assert max(errors) / 13.2 == pytest.approx(0.0893, abs=5e-5)


def test_euler_output_is_constant_between_samples() -> None:
    plant = SampledPlant(COURSE._replace(method=EULER), SAMPLE_TIME)
    plant.set_input(0.0, 1.0)
    assert plant.output(0.02) == plant.output(0.0399) < plant.output(0.04)


def test_method_can_be_changed_at_run_time() -> None:
    plant = SampledPlant(COURSE, SAMPLE_TIME)
    plant.set_input(0.0, 1.0)
    exact = plant.output(0.04)
    plant.change(0.04, COURSE._replace(method=EULER), SAMPLE_TIME)
    by_slides = exact + 0.02 / 0.05 * (13.2 - exact)
    assert plant.output(0.06) == pytest.approx(by_slides, abs=1e-12)
    plant.change(0.06, COURSE, SAMPLE_TIME)
    assert plant.output(0.07) == pytest.approx(decay(by_slides, 13.2, 0.01, 0.05), abs=1e-12)


def test_unstable_euler_stays_within_the_limit() -> None:
    plant = SampledPlant(LIMITED._replace(method=EULER), 0.2)
    plant.set_input(0.0, 0.5)
    got = [plant.output(number * 0.2) for number in range(4)]
    assert got == pytest.approx([0.0, 13.0, -12.6, 13.0], abs=1e-9)
    assert abs(plant.output(1.7e9)) <= 13.0


@pytest.mark.parametrize("tau", [0.05, 1e6])
def test_euler_continues_after_clock_jump(tau: float) -> None:
    settings = PlantSettings(gain=13.2, time_constant=tau, method=EULER)
    plant = SampledPlant(settings, SAMPLE_TIME)
    plant.set_input(0.01, 1.0)
    assert plant.output(1e6) == pytest.approx(step_response(settings, 1e6), abs=1e-4)
    plant.set_input(1.7e9, 0.0)
    last = 13.2 if tau == 0.05 else step_response(settings, 1.7e9)
    assert plant.output(1.7e9) == pytest.approx(last, abs=SAMPLE_TIME / tau * 13.2 + 1e-9)


def test_input_without_sampler_acts_immediately() -> None:
    plant = FirstOrderPlant(COURSE)
    plant.hold(0.013, 1.0)
    assert plant.held == 1.0
    assert plant.output(0.014) == pytest.approx(step_response(COURSE, 0.001), abs=1e-12)
    plant.hold(0.02, 0.0)
    expected = decay(step_response(COURSE, 0.007), 0.0, 0.01, 0.05)
    assert plant.output(0.03) == pytest.approx(expected, abs=1e-12)
