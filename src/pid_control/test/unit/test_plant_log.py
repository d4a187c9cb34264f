"""Tests of the conversion of a real plant's log to rows and answers."""

import pytest

from pid_control.judging.plant_log import PlantLog, answers_of, rows_of
from pid_control.judging.scenarios import BY_NAME, SCENARIOS

#: A plant of twice the course's speed, heard every 10 ms by a clock that says 100 at the start.
ZERO, SCALE = 100.0, 2.0
RAMP = BY_NAME["ramp"]


def test_suits_any_plant_is_true_for_plain_set_points() -> None:
    found = [scenario.name for scenario in SCENARIOS if scenario.suits_any_plant]
    assert found == ["steps", "ramp", "sine", "windup"]


def test_rows_of_selects_scenario_and_scales_speed() -> None:
    heard = PlantLog([(ZERO + 0.01 * n, 4.0, 0.001 * n) for n in range(-50, 300)], [])
    rows = rows_of(heard, RAMP, ZERO, SCALE)
    assert len(rows) == 200
    assert rows[0].time == 0.0 and rows[-1].time == pytest.approx(1.99)
    assert {row.speed for row in rows} == {2.0}
    assert rows[110].set_point == pytest.approx(4.5)  # half way from 0.2 s to 2 s
    assert rows[110].input == pytest.approx(0.11)


def test_rows_of_averages_encoder_steps_causally() -> None:
    """One count more in every other sample; then a leap."""
    speeds = [5.0 + (n % 2) * 0.5 for n in range(100)] + [9.0] * 20
    heard = PlantLog([(ZERO + 0.01 * n, speed, 0.0) for n, speed in enumerate(speeds)], [])
    rows = rows_of(heard, RAMP, ZERO, 1.0)
    assert all(abs(row.speed - 5.25) <= 0.051 for row in rows[4:100])
    assert rows[100].speed == pytest.approx(6.1, abs=0.16)  # 9 and the three or four before


def test_answers_of_uses_scenario_time() -> None:
    heard = PlantLog([], [(ZERO - 0.25, 0.5), (ZERO + 0.5, -1.0)])
    assert answers_of(heard, ZERO) == [(-0.25, 0.5), (0.5, -1.0)]
