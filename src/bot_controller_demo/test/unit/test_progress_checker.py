"""Progress towards a goal."""

import math

import pytest

from bot_controller_demo.control.geometry import Errors
from bot_controller_demo.control.goal_controller import DRIVING, TURNING
from bot_controller_demo.control.progress_checker import ProgressChecker


def test_stopped_robot_counts_from_its_stop() -> None:
    progress_checker = ProgressChecker()
    for step in range(100):
        assert (
            progress_checker.lasted(DRIVING, Errors(2.0 - 0.01 * step, 0.0, 0.0), 0.1 * step) < 0.3
        )
    for step in range(100, 200):
        lasted = progress_checker.lasted(DRIVING, Errors(1.01, 0.0, 0.0), 0.1 * step)
    assert lasted == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("gain", [0.5, 0.01])
def test_a_slow_approach_is_progress(gain: float) -> None:
    progress_checker = ProgressChecker()
    for step in range(5000):
        distance = 2.0 * math.exp(-gain * 0.1 * step)
        assert progress_checker.lasted(DRIVING, Errors(distance, 0.0, 0.0), 0.1 * step) < 1.5


def test_a_drive_to_a_goal_far_away_is_progress() -> None:
    """At 0.22 m/s a robot makes less than 1 % of 300 m in 10 s."""
    progress_checker = ProgressChecker()
    for step in range(13000):
        seen = Errors(300.0 - 0.022 * step, 0.0, 0.0)
        assert progress_checker.lasted(DRIVING, seen, 0.1 * step) < 0.5


@pytest.mark.parametrize("phase", [DRIVING, TURNING])
def test_a_turn_is_progress_and_going_round_and_round_is_not(phase: str) -> None:
    progress_checker = ProgressChecker()
    for step in range(300):
        angle = 3.0 - 0.01 * step
        seen = Errors(1.0, angle, 0.0) if phase == DRIVING else Errors(0.05, 0.0, angle)
        assert progress_checker.lasted(phase, seen, 0.1 * step) < 0.7
    for step in range(300, 3000):
        seen = Errors(1.0 + 0.1 * math.sin(step), math.sin(0.1 * step), math.sin(0.1 * step))
        lasted = progress_checker.lasted(phase, seen, 0.1 * step)
    assert lasted > 200.0


def test_a_new_goal_and_a_clock_that_goes_back_start_over() -> None:
    progress_checker = ProgressChecker()
    seen = Errors(1.0, 0.0, 0.0)
    progress_checker.lasted(DRIVING, seen, 100.0)
    assert progress_checker.lasted(DRIVING, seen, 109.0) == 9.0
    assert progress_checker.lasted(DRIVING, seen, 50.0) == 0.0
    assert progress_checker.lasted(DRIVING, seen, 52.0) == 2.0
    progress_checker.forget()
    assert progress_checker.lasted(DRIVING, seen, 60.0) == 0.0
