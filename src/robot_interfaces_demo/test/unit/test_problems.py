"""Problems found in a message."""

import math
from typing import FrozenSet, List

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from hypothesis import given
from hypothesis import strategies as st

from nodekit import to_float32
from robot_custom_interfaces.msg import RobotStatus
from robot_interfaces_demo.modes import Mode, name_of
from robot_interfaces_demo.monitoring.problems import LIMITS, Level, Problem, find_problems
from robot_interfaces_demo.monitoring.settings import FleetMonitorParameters

SETTINGS = FleetMonitorParameters()
FINE = [12.0, 25.0, 1.0]
NOTHING: FrozenSet[Problem] = frozenset()


def found(
    mode: int = 0, readings: List[float] = FINE, before: FrozenSet[Problem] = NOTHING
) -> FrozenSet[Problem]:
    return find_problems(mode, [to_float32(reading) for reading in readings], before, SETTINGS)


def test_numbers_are_those_of_the_messages() -> None:
    for mode in Mode:
        assert getattr(RobotStatus, f"MODE_{mode.name}") == mode
    assert [int(level) for level in Level] == [
        DiagnosticStatus.OK,
        DiagnosticStatus.WARN,
        DiagnosticStatus.ERROR,
    ]
    assert [name_of(mode) for mode in (0, 4, 5)] == ["idle", "error", "5"]


@pytest.mark.parametrize(
    "mode, readings, expected",
    [
        (0, FINE, []),
        (3, [11.0, 40.0, 0.3, math.nan], []),  # a limit is allowed; what is too much is ignored
        (4, FINE, [Problem.ERROR_MODE]),
        (5, FINE, [Problem.UNKNOWN_MODE]),
        (255, [], [Problem.UNKNOWN_MODE, Problem.SHORT]),
        (0, [12.0, 25.0], [Problem.SHORT]),
        (0, [10.99, 25.0, 1.0], [Problem.LOW_BATTERY]),
        (0, [12.0, 40.01, 1.0], [Problem.HOT]),
        (0, [12.0, 25.0, 0.29], [Problem.NEAR_OBSTACLE]),
        (0, [math.nan, 25.0, 1.0], [Problem.NOT_FINITE]),
        (0, [12.0, -math.inf, math.inf], [Problem.NOT_FINITE]),
        (0, [math.inf, 50.0], [Problem.SHORT, Problem.NOT_FINITE, Problem.HOT]),
    ],
)
def test_each_problem_is_found(mode: int, readings: List[float], expected: List[Problem]) -> None:
    assert found(mode, readings) == set(expected)


@pytest.mark.parametrize("limit", [0.1, 0.7, 11.1, 12.3])
def test_a_reading_that_a_message_rounds_from_its_limit_is_allowed(limit: float) -> None:
    settings = FleetMonitorParameters(
        battery_low=limit, temperature_high=limit, obstacle_near=limit
    )
    assert not find_problems(0, [to_float32(limit)] * 3, NOTHING, settings)


def test_warning_ends_with_hysteresis() -> None:
    for index, (before, stays, ends) in enumerate(
        [(10.9, 11.21, 11.23), (40.1, 39.21, 39.19), (0.2, 0.305, 0.307)]
    ):
        present, problem = NOTHING, LIMITS[index].problem
        for reading, is_wrong in ((stays, False), (before, True), (stays, True), (ends, False)):
            readings = list(FINE)
            readings[index] = reading
            present = found(0, readings, present)
            assert (problem in present) is is_wrong, (problem, reading)


def test_a_limit_below_zero_has_its_hysteresis_on_the_good_side() -> None:
    settings = FleetMonitorParameters(temperature_high=-10.0, hysteresis=0.1)
    hot = frozenset([Problem.HOT])
    assert Problem.HOT in find_problems(0, [12.0, -10.5, 1.0], hot, settings)
    assert Problem.HOT not in find_problems(0, [12.0, -11.5, 1.0], hot, settings)
    assert Problem.HOT not in find_problems(0, [12.0, -10.5, 1.0], NOTHING, settings)


@given(st.sets(st.sampled_from([limit.problem for limit in LIMITS])))
def test_missing_reading_keeps_its_warning(before: FrozenSet[Problem]) -> None:
    before = frozenset(before)
    assert found(0, [math.nan] * 3, before) == before | {Problem.NOT_FINITE}
    assert found(0, [], before) == before | {Problem.SHORT}


@given(st.integers(0, 255), st.lists(st.floats(width=32), max_size=6))
def test_any_reading_can_be_checked(mode: int, readings: List[float]) -> None:
    problems = found(mode, readings)
    assert (Problem.UNKNOWN_MODE in problems) == (mode > 4)
    assert (Problem.SHORT in problems) == (len(readings) < 3)
    assert (Problem.NOT_FINITE in problems) == (not all(map(math.isfinite, readings[:3])))
