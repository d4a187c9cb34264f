"""Tests of the scenarios and their simulation."""

import math

import pytest

from pid_control.judging.experiment import Experiment
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.judging.scenarios import (
    BY_NAME,
    LITTLE,
    MOTOR,
    SLOW_STEP_S,
    STEP_S,
    Scenario,
    scaled,
    sine,
    steps,
    value_at,
)
from played import pi, play_one

each_scenario = pytest.mark.parametrize("name", sorted(BY_NAME))


def test_a_signal_is_straight_between_its_corners_and_new_at_a_step() -> None:
    corners = ((0.0, 1.0), (2.0, 3.0), (2.0, 7.0))
    moments = {-1.0: 1.0, 0.0: 1.0, 0.5: 1.5, 1.999: 2.999, 2.0: 7.0, 9.0: 7.0}
    for time, value in moments.items():
        assert value_at(corners, time) == pytest.approx(value)


def test_steps_begin_at_0() -> None:
    found = steps((0.2, 5.0), (1.0, -2.0))
    assert [value_at(found, time) for time in (0.0, 0.19, 0.2, 0.99, 1.0, 9.0)] == [
        0.0,
        0.0,
        5.0,
        5.0,
        -2.0,
        -2.0,
    ]


def test_sine_matches_math_sin() -> None:
    found = sine(5.0, 3.0, 1.0, 0.2, 2.2)
    assert value_at(found, 0.1) == 0.0
    for time in (0.2, 0.45, 0.7, 1.33, 2.1):
        expected = 5.0 + 3.0 * math.sin(2.0 * math.pi * (time - 0.2))
        assert value_at(found, time) == pytest.approx(expected, abs=0.01)


@each_scenario
def test_each_is_measured_and_begins_at_rest(name: str) -> None:
    scenario = BY_NAME[name]
    assert SCENARIO_METRICS[name]
    held = scenario.held_speed
    asked = value_at(scenario.set_point, 0.0)
    if held is not None:
        assert asked == value_at(held, 0.0)
    elif scenario.silence[0] > 0.0:
        assert asked == 0.0


@each_scenario
def test_each_covers_its_time(name: str) -> None:
    record = play_one(name, pi())
    times = [row.time for row in record.rows]
    assert times == sorted(times) and 0.0 <= times[0] < STEP_S
    assert record.scenario.duration - times[-1] < SLOW_STEP_S + 1e-9


def sent_at(scenario: Scenario, *moments: float) -> list:
    """Return what is sent in a scenario that begins at 20 s, a second after the motor."""
    experiment = Experiment(scenario, 19.0)
    experiment.begin_at(20.0)
    return [experiment.send(20.0 + moment) for moment in moments]


def test_set_points_arrive_at_100_hz_and_outputs_with_each_step() -> None:
    scenario = BY_NAME["steps"]._replace(silence=(math.inf, math.inf))
    sent = sent_at(scenario, *(index * STEP_S for index in range(51)))
    assert [one.set_point is not None for one in sent] == [i % 5 == 0 for i in range(51)]
    assert all(one.output is not None for one in sent)
    assert sent[50].output.time == pytest.approx(1.0 + 50 * STEP_S)
    # What a slow clock leaves out is not made up for.
    sent = sent_at(scenario, 0.0, 0.07, 0.072, 0.08)
    assert [one.set_point is not None for one in sent] == [True, True, False, True]


def test_restarted_motor_is_silent_and_starts_at_zero() -> None:
    experiment = Experiment(BY_NAME["restart"], -1.0)
    experiment.begin_at(0.0)
    experiment.answer(0.0, 0.5)
    before, silent = experiment.send(0.99), experiment.send(1.098)
    assert before.output.time == pytest.approx(1.99) and before.output.speed > 6.5
    assert silent.output is None and silent.set_point is not None
    after, later = experiment.send(1.1), experiment.send(1.2)
    assert after.output.time == 0.0 and after.output.speed < 0.5
    assert later.output.time == pytest.approx(0.1)


def test_a_motor_that_only_falls_silent_keeps_its_time_and_its_speed() -> None:
    experiment = Experiment(BY_NAME["missing"], -1.0)
    experiment.begin_at(0.0)
    experiment.answer(0.0, 0.5)
    before, silent, after = (experiment.send(moment) for moment in (0.99, 1.1, 1.2))
    assert silent.output is None
    assert after.output.time == pytest.approx(2.2)
    assert after.output.speed == pytest.approx(before.output.speed) and before.output.speed > 6.5


def test_nan_arrives_once_on_each_topic() -> None:
    scenario = BY_NAME["nan"]
    sent = sent_at(scenario, *(index * STEP_S for index in range(1200)))
    outputs = [i * STEP_S for i, one in enumerate(sent) if math.isnan(one.output.speed)]
    points = [
        i * STEP_S
        for i, one in enumerate(sent)
        if one.set_point is not None and math.isnan(one.set_point)
    ]
    assert outputs == [pytest.approx(0.9)] and points == [pytest.approx(1.5)]
    # The motor recovers from each.
    assert list(scenario.events) == pytest.approx([*outputs, *points])


@pytest.mark.parametrize("name", ["missing", "restart", "early"])
def test_recovery_counts_from_the_first_output_after_a_silence(name: str) -> None:
    scenario = BY_NAME[name]
    [event] = scenario.events
    silent, heard = sent_at(scenario, event - STEP_S, event)
    assert silent.output is None and heard.output is not None


def test_noise_is_measured_and_does_not_move_the_motor() -> None:
    experiment = Experiment(BY_NAME["noise"], -1.0)
    assert experiment.send(-0.5).output.speed == 0.0
    experiment.begin_at(0.0)
    heard = [experiment.send(index * STEP_S).output.speed for index in range(400)]
    deviation = math.sqrt(sum(value**2 for value in heard) / len(heard))
    assert deviation == pytest.approx(0.1, rel=0.15)
    assert {row.speed for row in experiment.rows} == {0.0}
    # Each controller has the same noise.
    again = sent_at(BY_NAME["noise"], *(index * STEP_S for index in range(400)))
    assert [one.output.speed for one in again] == heard


def test_the_motor_follows_its_input_its_load_and_nothing_that_is_not_finite() -> None:
    experiment = Experiment(BY_NAME["load"], -1.0)
    experiment.begin_at(0.0)
    experiment.answer(0.0, 0.5)
    experiment.answer(0.1, math.nan)
    assert experiment.send(0.9).output.speed == pytest.approx(6.55, abs=1e-3)
    experiment.send(1.0)
    assert experiment.send(1.9).output.speed == pytest.approx(13.1 * 0.3, abs=1e-3)
    assert experiment.rows[-1].input == 0.5


def test_other_motors_are_as_they_are_called() -> None:
    slower, faster = BY_NAME["slower"].motor, BY_NAME["faster"].motor
    assert slower.gain < MOTOR.gain < faster.gain
    assert slower.time_constant > MOTOR.time_constant > faster.time_constant
    has_motor = {name: Experiment(one, 0.0).has_motor for name, one in BY_NAME.items()}
    assert [name for name, has in has_motor.items() if not has] == ["early"]


def test_the_clock_becomes_slow() -> None:
    experiment = Experiment(BY_NAME["rate"], -1.0)
    experiment.begin_at(0.0)
    begin, end = BY_NAME["rate"].slow
    for moment, expected in ((begin - 0.1, STEP_S), (begin, SLOW_STEP_S), (end, STEP_S)):
        assert experiment.step_after(moment) == expected


def test_rate_asks_for_little_of_a_controller_with_large_gains() -> None:
    def error(gain: float, growth: float) -> float:
        return max(value for _, value in scaled(BY_NAME["rate"], gain, growth).set_point)

    assert error(0.08, 1.5) == pytest.approx(0.3 / (0.08 + 0.7 * 1.5))
    assert error(0.7, 73.0) < 0.01
    assert error(0.0, 0.0) == LITTLE
    assert scaled(BY_NAME["steps"], 0.7, 73.0) == BY_NAME["steps"]
