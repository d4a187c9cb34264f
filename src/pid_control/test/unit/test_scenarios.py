"""Tests of the scenarios and their simulation."""

import math

import pytest
from first_order_sys_sim.first_order_plant import PlantSettings

from pid_control.judging.experiment import Experiment
from pid_control.judging.metrics import SCENARIO_METRICS
from pid_control.judging.record import Row
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


def test_scenarios_are_as_documented() -> None:
    """Set point, load, and what else differs; see the tables of judge.md."""
    changed = {}
    for name, scenario in BY_NAME.items():
        plain = Scenario(name, scenario.about, scenario.duration, ((0.0, 0.0),))
        pairs = zip(Scenario._fields, scenario, plain)
        changed[name] = {field: one for field, one, other in pairs if one != other}
        times = [time for time, _ in changed[name].pop("set_point")]
        assert times == sorted(times) and times[-1] <= scenario.duration
    far, near = (0.2, 1.5, 3.0, 3.6, 4.8, 6.1, 7.6, 8.2), [20.0, 5.0] * 2 + [-20.0, -5.0] * 2
    assert BY_NAME["windup"].set_point == steps(*zip(far, near))
    assert BY_NAME["ramp"].set_point == ((0.0, 0.0), (0.2, 0.0), (2.0, 9.0))
    others = {
        "steps": ((0.2, 5.0), (1.2, 9.0), (2.2, 3.0), (3.2, -4.0)),
        "slower": ((0.2, 5.0), (1.2, 8.0)),
        "faster": ((0.2, 5.0), (1.2, 8.0)),
        "missing": ((0.2, 5.0), (1.0, 8.0)),
        **dict.fromkeys(("noise", "load", "restart", "nan"), ((0.2, 5.0),)),
    }
    assert all(BY_NAME[name].set_point == steps(*corners) for name, corners in others.items())
    moves = (0.1, 0.5, 0.9, 1.6, 2.3, 2.6)
    assert BY_NAME["rate"].set_point == steps(*zip(moves, [LITTLE, -LITTLE] * 3))
    durations = (5.3, 2.9, 4.5, 2.0, 2.2, 9.4, 1.5, 2.0, 2.2, 2.2, 2.0, 2.0, 1.8, 2.4)
    assert [one.duration for one in BY_NAME.values()] == pytest.approx(durations)
    assert BY_NAME["early"].set_point == ((0.0, 5.0),)
    assert BY_NAME["sine"].set_point == sine(5.0, 3.0, 1.0, 0.2, 2.2)
    del changed["held"]["held_speed"]
    assert changed == {
        "held": {"pauses": (5.2,)},
        "rate": {"held_speed": ((0.0, 0.0),), "slow": (0.9, 2.3), "pauses": (0.3, 0.7)},
        "steps": {},
        "ramp": {},
        "sine": {},
        "windup": {"events": far[1::2]},
        "noise": {"noise": 0.1},
        "load": {"load": steps((1.0, -0.2)), "events": (1.0,)},
        "slower": {"motor": PlantSettings(MOTOR.gain * 0.8, MOTOR.time_constant * 2.0, *MOTOR[2:])},
        "faster": {"motor": PlantSettings(MOTOR.gain * 1.2, MOTOR.time_constant / 2.0, *MOTOR[2:])},
        "missing": {"silence": (1.0, 1.2), "events": (1.2,)},
        "restart": {"silence": (1.0, 1.1), "restarts": True, "events": (1.1,)},
        "early": {"silence": (-math.inf, 0.6), "restarts": True, "events": (0.6,)},
        "nan": {
            "not_a_number": ((0.9, "motor_output"), (1.5, "set_point")),
            "events": (0.9, 1.5),
        },
    }


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
    experiment = Experiment(BY_NAME["restart"], 4.0)
    experiment.begin_at(5.0)
    experiment.answer(5.0, 0.5)
    before, silent, last = (experiment.send(5.0 + moment) for moment in (0.99, 1.05, 1.098))
    assert before == (5.0, (pytest.approx(6.55), pytest.approx(1.99), "Motor Turning"))
    assert silent == last == (5.0, None)
    after, later, full = (experiment.send(5.0 + moment) for moment in (1.1, 1.2, 1.21))
    # It turns by its latest input again.
    assert after == (None, (pytest.approx(0.319, abs=1e-3), 0.0, "Motor Turning"))
    assert later == (5.0, (pytest.approx(6.04, abs=1e-2), pytest.approx(0.1), "Motor Turning"))
    assert full.output.time == pytest.approx(0.11)


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
    assert silent.output is None
    assert heard.output.time == (0.0 if scenario.restarts else pytest.approx(1.0 + event))


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
    experiment = Experiment(BY_NAME["load"], 4.0)
    experiment.begin_at(5.0)
    experiment.send(4.5)  # before the scenario: not in its rows
    experiment.answer(5.0, 0.25)
    experiment.answer(5.1, 0.5)
    experiment.answer(5.2, math.nan)
    assert experiment.send(5.9).output.speed == pytest.approx(6.55, abs=1e-3)
    experiment.send(6.0)
    assert experiment.send(6.9).output.speed == pytest.approx(13.1 * 0.3, abs=1e-3)
    assert experiment.rows == [
        Row(0.9, 5.0, pytest.approx(6.55, abs=1e-3), 0.5),
        Row(1.0, 5.0, pytest.approx(6.55, abs=1e-3), 0.5),
        Row(1.9, 5.0, pytest.approx(3.93, abs=1e-3), 0.5),
    ]


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
    assert error(0.7, 73.0) == error(-0.7, -73.0) == pytest.approx(0.3 / (0.7 + 0.7 * 73.0))
    assert (error(0.001, 0.0), error(0.5, 1e6)) == (2.0, 5e-4)
    assert error(0.0, 0.0) == LITTLE
    assert scaled(BY_NAME["steps"], 0.7, 73.0) == BY_NAME["steps"]
