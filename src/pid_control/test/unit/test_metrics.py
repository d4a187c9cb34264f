"""Tests of the metrics of controllers with known answers."""

import math
import random
from typing import Callable, Optional

import pytest

from pid_control.controller.pid import PID
from pid_control.judging.experiment import MotorOutput
from pid_control.judging.line_fit import fit_line
from pid_control.judging.metrics import (
    METRICS,
    SCENARIO_METRICS,
    growths,
    leave_times,
    metrics_of,
)
from pid_control.judging.record import Pause, Record, Row
from pid_control.judging.scenarios import BY_NAME, MOTOR, Scenario, scaled, steps, value_at
from played import Law, pi, play, play_all, play_one


def figure(record: Record, name: str) -> Optional[float]:
    return METRICS[name].of(record)


def test_a_line_through_points() -> None:
    line = fit_line([(x, 3.0 - 2.0 * x) for x in (0.0, 1.0, 2.0, 5.0)])
    assert line == pytest.approx((-2.0, 3.0))
    assert line is not None and line.at(10.0) == pytest.approx(-17.0)
    assert fit_line([(0.0, 1.0), (1.0, 2.0), (2.0, 3.0)]) is None
    assert fit_line([(1.0, float(y)) for y in range(4)]) is None


def test_every_figure_is_taken_and_a_good_controller_has_small_ones() -> None:
    for record in play_all(pi()):
        figures = metrics_of(record)
        assert list(figures) == list(SCENARIO_METRICS[record.scenario.name])
        assert all(value is None or math.isfinite(value) for value in figures.values())
    assert set(METRICS) == {name for names in SCENARIO_METRICS.values() for name in names}


#: Up by 10 immediately, and down by 4 a second later.
TWO_STEPS = Scenario("steps", "", 2.0, steps((0.0, 10.0), (1.0, 6.0)))


def rows_of(speed: Callable[[float], float], scenario: Scenario = TWO_STEPS) -> Record:
    rows = [
        Row(index * 0.01, 10.0 if index < 100 else 6.0, speed(index * 0.01), 0.5)
        for index in range(200)
    ]
    return Record(scenario, rows=rows)


def test_rise_time_of_an_exponential() -> None:
    def speed(time: float) -> float:
        if time < 1.0:
            return 10.0 - 10.0 * math.exp(-time / 0.1)
        return 6.0 + 4.0 * math.exp(-(time - 1.0) / 0.1)

    record = rows_of(speed)
    # From 10 % to 90 % takes tau ln 9, and from the step to 95 % tau ln 20.
    assert figure(record, "rise_time") == pytest.approx(0.1 * math.log(9.0), abs=0.02)
    assert figure(record, "settling_time") == pytest.approx(0.1 * math.log(20.0), abs=0.02)
    assert figure(record, "overshoot") == 0.0
    assert figure(record, "steady_error") == pytest.approx(0.0, abs=0.01)
    assert figure(record, "absolute_error") == pytest.approx(10 * 0.1 + 4 * 0.1, rel=0.1)
    assert figure(record, "effort") == pytest.approx(0.25 * 2.0, rel=0.01)


def test_rise_and_settling_time_unreached_are_infinite() -> None:
    record = rows_of(lambda time: 5.0 if time < 1.0 else 6.0)
    assert figure(record, "rise_time") == math.inf
    assert figure(record, "settling_time") == math.inf
    assert figure(record, "steady_error") == pytest.approx(5.0)
    above = rows_of(lambda time: 12.0 if time < 1.0 else 6.0)
    assert figure(above, "steady_error") == pytest.approx(2.0)
    late = rows_of(lambda time: (0.0 if time < 0.5 else 10.0) if time < 1.0 else 6.0)
    assert figure(late, "rise_time") == 0.0


def test_tracking_error_and_chatter_are_those_of_the_end() -> None:
    answers = [(index * 0.01, float(index < 100) * (index % 2)) for index in range(200)]
    record = rows_of(lambda time: 0.0 if time < 1.0 else 5.5)._replace(answers=answers)
    assert figure(record, "tracking_error") == pytest.approx(0.5)
    assert figure(record, "chatter") == 0.0


def test_the_overshoot_is_that_of_the_worst_step() -> None:
    def speed(time: float) -> float:
        if time < 1.0:
            return 11.0 if time < 0.1 else 10.0
        return 5.0 if time < 1.1 else 6.0

    assert figure(rows_of(speed), "overshoot") == pytest.approx(25.0)


def test_overshoot_of_a_stopped_motor_is_not_measured() -> None:
    still = rows_of(lambda time: 9.0)
    assert figure(still, "overshoot") is None


def test_late_and_chatter_are_measured() -> None:
    answers = [(index * 0.01, 0.1 * (index % 2)) for index in range(100)]
    record = rows_of(lambda time: 0.0)._replace(answers=answers)
    assert figure(record, "late") == pytest.approx(1.01 / 2.0)
    # Gaps of more than 25 ms, from the begin to the end of the scenario.
    some = [(-0.05, 0.0), (0.03, 0.0), (0.054, 0.0)]
    some += [(0.02 * step, 0.0) for step in range(4, 99)]
    gapped = record._replace(answers=[*some, (2.1, 0.0)])
    assert figure(gapped, "late") == pytest.approx((0.026 + 0.03 + 0.04) / 2.0)
    answers = [(index * 0.01, 0.1 * (index % 2)) for index in range(200)]
    record = record._replace(answers=answers)
    assert figure(record, "late") == 0.0
    assert figure(record, "chatter") == pytest.approx(0.1)
    assert not record.is_silent and record._replace(answers=answers[:100]).is_silent
    assert record._replace(answers=()).is_silent


def test_the_peak_is_of_either_sign_and_of_numbers() -> None:
    record = rows_of(lambda time: 0.0)._replace(
        answers=[(0.0, 0.5), (0.1, -3.0), (0.2, math.nan), (0.3, math.inf)]
    )
    assert figure(record, "peak_input") == 3.0
    assert figure(record._replace(answers=()), "peak_input") is None


def test_nan_is_excused_only_just_after_nan_was_sent() -> None:
    scenario = BY_NAME["nan"]
    answers = [(0.5, math.nan), (0.95, math.nan), (1.2, math.inf), (1.3, 0.1), (1.55, math.nan)]
    assert figure(Record(scenario, answers=answers), "not_finite") == 2.0
    late = [(0.89, math.nan), (0.9, math.nan), (0.99, math.inf), (1.01, -math.inf)]
    assert figure(Record(scenario, answers=late), "not_finite") == 2.0


def test_processor_time_is_that_of_a_second() -> None:
    assert figure(Record(TWO_STEPS, busy=3.0), "processor") == 1.5


def test_windup_keeps_the_input_at_its_limit() -> None:
    good = play_one("windup", pi())
    assert figure(good, "leave_time") == pytest.approx(0.0, abs=0.01)
    bad = play_one("windup", pi(anti_windup="none"))
    # At 20 rad/s wanted and 13 there, the integral has grown by ki 7 rad/s 1.3 s and more.
    assert leave_times(bad) == pytest.approx([1.066, 0.462, 1.06, 0.462], abs=0.005)
    assert figure(bad, "leave_time") == max(leave_times(bad))


def slow_pi(interval: Optional[float]) -> Callable[[], Law]:
    """PI that takes a constant for dt, or the outputs' own times."""

    def make() -> Law:
        state = {"integral": 0.0, "before": 0.0}

        def answer(set_point: float, output: MotorOutput) -> float:
            dt = output.time - state["before"] if interval is None else interval
            state["before"] = output.time
            error = set_point - output.speed
            state["integral"] += error * dt
            return 0.06 * error + 1.2 * state["integral"]

        return answer

    return make


def test_a_constant_interval_shows_where_the_loop_is_slow() -> None:
    assert figure(play_one("rate", slow_pi(None)), "interval_error") < 0.05
    # 2 ms are taken for what lasts 70 ms.
    error = figure(play_one("rate", slow_pi(0.002)), "interval_error")
    assert error == pytest.approx(1.0 - 2.0 / 70.0, abs=0.02)
    quick, slow = growths(play_one("rate", slow_pi(0.004)))  # 4 ms, for what lasts 2 ms
    assert (quick, slow) == pytest.approx((2 * 1.2 * 0.1, 4.0 / 70.0 * 1.2 * 0.1), rel=0.01)
    assert figure(play_one("rate", pi(ki=0.0)), "interval_error") is None


def test_interval_error_of_an_integral_that_reaches_its_limit_is_not_measured() -> None:
    assert figure(play_one("rate", pi(ki=73.0)), "interval_error") is None
    small = scaled(BY_NAME["rate"], 0.08, 73.0)
    assert figure(play(small, pi(ki=73.0)()), "interval_error") < 0.05


def test_held_makes_errors_of_all_sizes_by_the_set_point_and_by_the_motor() -> None:
    held = BY_NAME["held"]
    times = [0.1 * step + 0.05 for step in range(int(10 * held.duration))]
    errors = [value_at(held.set_point, time) - value_at(held.held_speed, time) for time in times]
    probe = [1.0, -1.0, -1.0, 1.0, 0.0]
    sizes = [0.001, 0.01, 0.1, 1.0, 10.0]
    twice = [size for size in sizes for _ in ("set_point", "motor_output")]
    expected = [0.0, 0.0, *(size * sign for size in twice for sign in probe), 0.0]
    assert errors == pytest.approx(expected)
    of_set_point = {round(time, 2) for time in times if value_at(held.set_point, time)}
    assert {round(time + 0.5, 2) for time in of_set_point} == {
        round(time, 2) for time in times if value_at(held.held_speed, time)
    }


def test_both_responses_and_their_signs() -> None:
    record = play_one("held", pi())
    assert figure(record, "set_point_response") == pytest.approx(0.08 + 0.1 * 1.5, rel=0.01)
    assert figure(record, "output_response") == pytest.approx(0.08 + 0.1 * 1.5, rel=0.01)
    inverse = play_one("held", pi(kp=-0.08, ki=-1.5))
    assert figure(inverse, "set_point_response") < 0.0
    assert figure(inverse, "output_response") < 0.0

    def make_deaf() -> Law:
        return lambda set_point, output: 0.1 * set_point

    deaf = play_one("held", make_deaf)
    assert figure(deaf, "output_response") == 0.0
    assert figure(deaf, "set_point_response") == pytest.approx(0.1)


def test_response_of_a_constant_input_is_0_and_unknown_at_a_limit() -> None:
    for value, response in ((0.5, 0.0), (-1.0, None)):
        constant = play_one("held", lambda value=value: lambda point, output: value)
        assert figure(constant, "set_point_response") == response
        assert figure(constant, "output_response") == response


@pytest.mark.parametrize("kp, ki", [(0.5, 27.0), (0.5, 73.0), (0.5, 300.0), (0.002, 0.01)])
def test_responses_of_large_and_small_gains_are_measured(kp: float, ki: float) -> None:
    record = play_one("held", pi(kp=kp, ki=ki))
    for name in ("set_point_response", "output_response"):
        assert figure(record, name) == pytest.approx(kp + 0.1 * ki, rel=0.01)
    assert figure(record, "kick") == pytest.approx(0.0, abs=1e-6)


def test_responses_of_an_input_that_switches_are_not_measured() -> None:
    def make_switch() -> Law:
        return lambda set_point, output: math.copysign(1.0, set_point - output.speed)

    record = play_one("held", make_switch)
    assert figure(record, "set_point_response") is None
    assert figure(record, "output_response") is None


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("ki", [0.0, 3.5])
def test_delay_that_is_uncertain_as_answers_are_lost_is_no_kick(seed: int, ki: float) -> None:
    draw, record = random.Random(seed), play_one("held", pi(kp=1.5, ki=ki))
    left = [
        (time, value + draw.gauss(0.0, 1e-7))
        for time, value in record.answers
        if draw.random() > 0.1
    ]
    assert figure(record._replace(answers=left), "kick") < 0.01


@pytest.mark.parametrize("ki", [1.5, 0.05])
def test_a_derivative_of_the_error_kicks_and_one_of_the_output_does_not(ki: float) -> None:
    def kicking(least: float) -> Callable[[], Law]:
        def make() -> Law:
            law, before = pi(ki=ki)(), [0.0]

            def answer(set_point: float, output: MotorOutput) -> float:
                error = set_point - output.speed
                kick, before[0] = 0.2 * max(error - before[0], least), error
                return law(set_point, output) + kick

            return answer

        return make

    assert figure(play_one("held", kicking(-math.inf)), "kick") == pytest.approx(0.2, abs=0.01)
    assert figure(play_one("held", kicking(0.0)), "kick") < 0.001  # not at each step
    assert figure(play_one("held", pi(mode=PID, ki=ki, kd=0.001)), "kick") < 0.001


def jumped(record: Record, *spans: float) -> Record:
    """Return a record of ``rate`` with an integral that grows during pauses, by these times [s]."""
    answers = record.answers
    error = record.scenario.set_point[2][1]
    for pause, span, sign in zip(record.pauses, spans, (1.0, -1.0)):
        answers = [
            (time, value + 1.5 * sign * error * span if time > pause.time else value)
            for time, value in answers
        ]
    return record._replace(answers=answers)


def test_integral_that_grows_while_the_clock_is_paused_is_found() -> None:
    record = play_one("rate", pi())
    assert figure(record, "standstill_jump") < 0.005
    assert figure(record._replace(pauses=()), "standstill_jump") is None
    # Without an integral, a change of the input is not one of its.
    assert figure(play_one("rate", pi(ki=5e-4)), "standstill_jump") is None
    assert figure(jumped(record, 0.02, 0.03), "standstill_jump") == pytest.approx(0.03, abs=5e-3)
    # The second pause is twice as long as the first.
    moved = jumped(record, 0.2, 0.4)
    assert figure(moved, "standstill_jump") == pytest.approx(0.2, abs=0.01)
    assert figure(moved, "interval_error") < 0.05  # that is another fault


def test_integral_of_the_wrong_sign_that_grows_while_the_clock_is_paused_is_found() -> None:
    record = play_one("rate", pi(kp=-0.08, ki=-1.5))
    answers = jumped(record._replace(answers=[(t, -u) for t, u in record.answers]), 0.2, 0.4)
    record = record._replace(answers=[(t, -u) for t, u in answers.answers])
    assert figure(record, "standstill_jump") == pytest.approx(0.2, abs=0.01)


def test_standstill_jump_without_proportion_to_the_pauses_is_not_measured() -> None:
    record = play_one("rate", pi())
    assert figure(jumped(record, 0.2, 0.2), "standstill_jump") is None
    assert figure(jumped(record, 0.2, 0.0), "standstill_jump") is None
    first, second = record.pauses
    longer = record._replace(pauses=[first, second._replace(length=3.0 * first.length)])
    assert figure(jumped(longer, 0.2, 0.6), "standstill_jump") == pytest.approx(0.2, abs=0.01)


def test_standstill_answers_and_rest_are_those_of_the_pause() -> None:
    record = play_one("held", pi())._replace(pauses=[Pause(5.0, 0.5, 0.75, 3)])
    assert figure(record, "standstill_answers") == 3.0
    assert figure(record, "standstill_rest") == 0.75
    assert figure(record._replace(pauses=()), "standstill_answers") is None


def test_leave_time_counts_from_the_limit_of_the_controller_on_either_side() -> None:
    for limits in ((-1.0, 0.9), (-0.5, 1.0)):
        settings = {"output_min": limits[0], "output_max": limits[1]}
        bad = play_one("windup", pi(anti_windup="none", **settings))
        assert figure(bad, "leave_time") > 0.5
        assert figure(play_one("windup", pi(**settings)), "leave_time") < 0.02
    assert figure(play_one("windup", pi(kp=0.0, ki=0.0)), "leave_time") == 0.0  # it has none


def test_recovery_is_counted_from_the_event() -> None:
    record = play(BY_NAME["load"]._replace(motor=MOTOR), pi()())
    assert 0.05 < figure(record, "recovery_time") < 0.5
    lost = play_one("load", pi(ki=0.0))
    assert figure(lost, "recovery_time") == math.inf


def test_recovery_is_that_of_the_slowest_of_several_events() -> None:
    record = play_one("nan", pi())
    rows = [row._replace(speed=0.0) if row.time > 1.5 else row for row in record.rows]
    assert figure(record, "recovery_time") == 0.0
    assert figure(record._replace(rows=rows), "recovery_time") == math.inf
