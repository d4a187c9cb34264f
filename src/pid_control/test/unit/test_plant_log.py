"""Tests of the conversion of a real plant's log to rows and answers."""

import pytest

from pid_control.judging.plant_log import PlantLog, answers_of, rows_of
from pid_control.judging.scenarios import BY_NAME, SCENARIOS

#: A plant of twice the course's speed, heard every 10 ms by a clock that says 100 at the start.
ZERO, SCALE = 100.0, 2.0
RAMP = BY_NAME["ramp"]


def test_only_those_that_ask_for_speeds_suit_any_plant() -> None:
    found = [scenario.name for scenario in SCENARIOS if scenario.suits_any_plant]
    assert found == ["steps", "ramp", "sine", "windup"]


def test_rows_are_of_the_scenario_and_of_the_courses_speed() -> None:
    heard = PlantLog([(ZERO + 0.01 * n, 4.0, 0.001 * n) for n in range(-50, 300)], [])
    rows = rows_of(heard, RAMP, ZERO, SCALE)
    assert len(rows) == 200
    assert rows[0].time == 0.0 and rows[-1].time == pytest.approx(1.99)
    assert {row.speed for row in rows} == {2.0}
    assert rows[110].set_point == pytest.approx(4.5)  # half way from 0.2 s to 2 s
    assert rows[110].input == pytest.approx(0.11)


def test_steps_of_an_encoder_are_no_errors_and_no_future_is_seen() -> None:
    """One count more in every other sample; then a leap."""
    speeds = [5.0 + (n % 2) * 0.5 for n in range(100)] + [9.0] * 20
    heard = PlantLog([(ZERO + 0.01 * n, speed, 0.0) for n, speed in enumerate(speeds)], [])
    rows = rows_of(heard, RAMP, ZERO, 1.0)
    assert all(abs(row.speed - 5.25) <= 0.051 for row in rows[4:100])
    assert rows[100].speed > 5.5


def test_answers_are_timed_from_the_start_on() -> None:
    heard = PlantLog([], [(ZERO - 0.25, 0.5), (ZERO + 0.5, -1.0)])
    assert answers_of(heard, ZERO) == [(-0.25, 0.5), (0.5, -1.0)]
