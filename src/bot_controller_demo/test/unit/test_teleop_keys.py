"""Commands of the keys, and their duration."""

from typing import List, Optional, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bot_controller_demo.control.velocities import STOP, Velocity
from bot_controller_demo.teleop.keys import (
    MOVES,
    SCALES,
    HeldKey,
    Teleoperation,
    TimeOuts,
    split,
)

TIME_OUTS = TimeOuts(0.6, 0.15)
SPEEDS = Velocity(0.2, 1.0)


def told(presses: List[Tuple[float, str]], until: float) -> List[Tuple[float, Velocity]]:
    """Return the commands and their times, for a node that polls every 10 ms.

    :param presses: times and keys, in order of time
    :param until: [s]
    """
    teleoperation, waiting, said = Teleoperation(), list(presses), []
    for number in range(round(until * 100)):
        now = number / 100
        while waiting and waiting[0][0] <= now:
            teleoperation.press(waiting.pop(0)[1], now, TIME_OUTS)
        velocity = teleoperation.velocity(now, SPEEDS, TIME_OUTS)
        if velocity is not None:
            said.append((now, velocity))
    return said


def held(key: str, start: float, end: float) -> List[Tuple[float, str]]:
    """Return the presses of a key that is held: repeated after 0.5 s, 30 times a second."""
    repeats = range(1000)
    times = [start] + [start + 0.5 + number / 30 for number in repeats]
    return [(time, key) for time in times if time <= end]


def moving(said: List[Tuple[float, Velocity]]) -> List[float]:
    """Return the times of commands to move."""
    return [time for time, velocity in said if velocity != STOP]


def zeros(said: List[Tuple[float, Velocity]]) -> List[float]:
    """Return the times of commands to stop."""
    return [time for time, velocity in said if velocity == STOP]


def test_held_key_drives_without_gap_and_ends_with_one_zero() -> None:
    """Course 001-robot-7."""
    said = told(held("i", 1.0, 3.0), 5.0)
    assert moving(said)[0] == 1.0
    assert 2.95 <= moving(said)[-1] <= 3.16
    assert len(moving(said)) == round((moving(said)[-1] - 1.0) * 100) + 1
    assert len(zeros(said)) == 1 and zeros(said)[0] == pytest.approx(moving(said)[-1] + 0.01)


def test_a_short_press_drives_for_the_first_time_out() -> None:
    said = told([(1.0, "i")], 5.0)
    assert moving(said)[-1] == pytest.approx(1.6, abs=0.02)
    assert len(zeros(said)) == 1


def test_two_quick_presses_by_hand_do_not_shake() -> None:
    said = told([(1.0, "i")] + held("i", 1.2, 3.0), 5.0)
    assert len(zeros(said)) == 1 and zeros(said)[0] > 2.9


def test_other_key_takes_over_with_own_first_timeout() -> None:
    said = told(held("i", 1.0, 2.0) + held("j", 2.0, 4.0), 6.0)
    assert dict(said)[1.9] == Velocity(0.2, 0.0) and dict(said)[2.1] == Velocity(0.0, 1.0)
    assert len(zeros(said)) == 1 and zeros(said)[0] > 3.9


@pytest.mark.parametrize("key", ["k", " ", "\x1b[A", "I", "q"])
def test_other_key_stops_immediately(key: str) -> None:
    said = told([(1.0, "i"), (1.2, key)], 3.0)
    assert zeros(said) == [1.2] and moving(said)[-1] < 1.2


def test_silence_before_the_first_key_and_after_a_key_that_does_not_move() -> None:
    assert told([(1.0, "k"), (2.0, "x"), (2.5, "?")], 3.0) == []


def test_key_after_stop_starts_again() -> None:
    key = HeldKey()
    key.press("i", 0.0, TIME_OUTS)
    key.release()
    key.press("i", 0.1, TIME_OUTS)
    assert key.held(0.5, TIME_OUTS) == "i"


@given(st.lists(st.tuples(st.floats(0.0, 4.0), st.sampled_from(["i", "j", ".", "k", "q"]))))
def test_last_command_after_any_input_is_one_zero(presses: List[Tuple[float, str]]) -> None:
    said = told(sorted(presses), 5.0)
    assert not said or said[-1][1] == STOP
    both = zip(said, said[1:])
    assert not any(one[1] == other[1] == STOP for one, other in both)


def test_the_keys_of_teleop_twist_keyboard() -> None:
    assert {key for key, move in MOVES.items() if move[0] > 0} == set("uio")
    assert {key for key, move in MOVES.items() if move[0] < 0} == set("m,.")
    assert {key for key, move in MOVES.items() if move[1] > 0} == set("uj.")
    assert {key for key, move in MOVES.items() if move[1] < 0} == set("olm")
    assert set(SCALES) == set("qzwxec") and not set(SCALES) & set(MOVES)


@pytest.mark.parametrize(
    "text, keys",
    [
        ("", []),
        ("iij", ["i", "i", "j"]),
        ("\x1b[Ai", ["\x1b[A", "i"]),
        ("\x1bOB\x1b[15~", ["\x1bOB", "\x1b[15~"]),
        ("\x1bi", ["\x1b", "i"]),
        ("\n", ["\n"]),
    ],
)
def test_terminal_input_is_split_into_keys(text: str, keys: List[str]) -> None:
    assert split(text) == keys


def velocity_of(teleoperation: Teleoperation, now: float) -> Optional[Velocity]:
    """Return the commands to a robot."""
    return teleoperation.velocity(now, SPEEDS, TIME_OUTS)


def test_speeds_apply_immediately() -> None:
    teleoperation = Teleoperation()
    teleoperation.press("u", 0.0, TIME_OUTS)
    assert velocity_of(teleoperation, 0.0) == Velocity(0.2, 1.0)
    assert teleoperation.velocity(0.1, Velocity(0.1, 0.5), TIME_OUTS) == Velocity(0.1, 0.5)
