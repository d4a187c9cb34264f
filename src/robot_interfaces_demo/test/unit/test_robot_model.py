"""The robot that robot_monitor plays."""

import math
from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_interfaces_demo.modes import Mode
from robot_interfaces_demo.monitoring.problems import Problem, find_problems
from robot_interfaces_demo.monitoring.settings import FleetMonitorParameters
from robot_interfaces_demo.robot_model import FAULTS, RobotModel, Status


def told(count: int, messages_per_mode: int) -> List[Status]:
    model = RobotModel()
    return [model.step(messages_per_mode) for _ in range(count)]


@given(st.integers(1, 20))
def test_it_goes_through_all_modes_again_and_again(per_mode: int) -> None:
    modes = [status.mode for status in told(11 * per_mode, per_mode)]
    # As in the course, the first mode is one message short.
    assert modes[: per_mode - 1] == [Mode.IDLE] * (per_mode - 1)
    for number in range(1, 10):
        block = modes[number * per_mode - 1 : (number + 1) * per_mode - 1]
        assert block == [number % 5] * per_mode


def test_battery_and_temperature_are_those_of_the_course() -> None:
    statuses = told(5 * 15, 15)
    for before, after in zip(statuses, statuses[1:]):
        change = after.readings[0] - before.readings[0]
        if after.mode == Mode.CHARGING:
            assert change == pytest.approx(min(0.03, 12.6 - before.readings[0]))
        else:
            assert change == pytest.approx(-0.005)
        warmer = after.readings[1] > before.readings[1]
        assert warmer == (after.mode in (Mode.MOVING, Mode.WORKING))
    assert statuses[0].readings[:2] == pytest.approx([12.495, 24.95])


@given(st.integers(1, 3000), st.integers(1, 1000))
def test_readings_are_within_bounds(count: int, per_mode: int) -> None:
    battery, temperature, obstacle = told(count, per_mode)[-1].readings
    assert 10.0 <= battery <= 12.6
    assert 20.0 <= temperature <= 45.0
    assert 0.5 <= obstacle <= 3.5


def test_the_bounds_are_reached() -> None:
    assert told(600, 10**6)[-1].readings[:2] == [10.0, 20.0]  # idle
    statuses = told(3999, 1000)
    assert statuses[1998].readings[1] == 45.0  # moving
    assert statuses[-1].readings[0] == 12.6  # charging


def test_an_obstacle_is_passed_every_forty_messages() -> None:
    distances = [status.readings[2] for status in told(80, 15)]
    assert distances[9:40:10] == pytest.approx([2.0, 0.5, 2.0, 3.5])
    assert distances[40:] == pytest.approx(distances[:40])


@pytest.mark.parametrize(
    "fault, mode, readings, problem",
    [
        ("low_battery", 1, [10.5, 25.0, 1.0], Problem.LOW_BATTERY),
        ("hot", 1, [12.0, 55.0, 1.0], Problem.HOT),
        ("near_obstacle", 1, [12.0, 25.0, 0.1], Problem.NEAR_OBSTACLE),
        ("not_finite", 1, [12.0, math.nan, 1.0], Problem.NOT_FINITE),
        ("short", 1, [12.0], Problem.SHORT),
        ("unknown_mode", 99, [12.0, 25.0, 1.0], Problem.UNKNOWN_MODE),
    ],
)
def test_each_fault_is_seen(fault: str, mode: int, readings: List[float], problem: Problem) -> None:
    fine = Status(1, [12.0, 25.0, 1.0])
    status = FAULTS[fault](fine)
    assert status.mode == mode
    assert status.readings == pytest.approx(readings, nan_ok=True)
    assert find_problems(*status, frozenset(), FleetMonitorParameters()) == {problem}
    assert FAULTS["none"](fine) == fine == Status(1, [12.0, 25.0, 1.0])
