"""Tests of which values moved in pauses of the simulated clock."""

import math
from typing import Callable, List, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pid_control.signal_judging.channels import Channel
from pid_control.signal_judging.clock_pauses import moved_in_pauses

INTERVAL = 0.1
PAUSES = [0.25, 0.55, 0.75, 1.15, 1.45, 1.65, 2.05, 2.35]


def record(value_at: Callable[[float], float]) -> Channel:
    times = [INTERVAL * index for index in range(27)]
    return Channel("/signal", "x", times, [value_at(time) for time in times])


def with_pauses(moved: Sequence[bool], jump: float = 0.2) -> Callable[[float], float]:
    """Return a sine that goes on in some pauses, by a phase each [rad]."""

    def value(time: float) -> float:
        passed = sum(jump for pause, moves in zip(PAUSES, moved) if moves and pause < time)
        return math.sin(0.1 * time + passed)

    return value


@pytest.mark.parametrize(
    ("moved", "answer"),
    [
        ([True] * 8, True),
        ([True] * 6 + [False] * 2, True),
        ([True] * 5 + [False] * 3, None),
        ([True] * 4 + [False] * 4, None),
        ([True] * 3 + [False] * 5, False),
    ],
)
def test_values_that_move_in_most_pauses_depend_on_the_machine_clock(
    moved: List[bool], answer: object
) -> None:
    found = record(with_pauses(moved))
    assert moved_in_pauses(found, PAUSES) is answer
    falling = found._replace(values=[-value for value in found.values])
    assert moved_in_pauses(falling, PAUSES) is answer
    broken = found._replace(times=[0.0, *found.times], values=[math.nan, *found.values])
    assert moved_in_pauses(broken, PAUSES) is answer


def test_a_move_is_more_than_twice_the_usual_changes() -> None:
    for jump, answer in ((0.005, False), (0.015, True)):  # beside 0.01 of a usual change
        assert moved_in_pauses(record(with_pauses([True] * 8, jump)), PAUSES) is answer


def test_pause_after_the_first_or_before_the_last_message_counts() -> None:
    for pause in (0.05, 2.55):
        moved = record(lambda time: 0.01 * time + (time > pause))
        assert moved_in_pauses(moved, [pause]) is True
        assert moved_in_pauses(moved, [-0.05, pause]) is True  # one before it has no change


@given(
    frequency=st.floats(0.1, 60.0),
    phase=st.floats(0.0, 6.3),
    shape=st.sampled_from([math.sin, lambda x: math.copysign(1.0, math.sin(x)), lambda x: x % 1.0]),
)
def test_no_function_of_the_simulated_clock_moves_in_pauses(
    frequency: float, phase: float, shape: Callable[[float], float]
) -> None:
    found = record(lambda time: shape(frequency * time + phase))
    assert moved_in_pauses(found, PAUSES) is not True


@given(repeats=st.integers(2, 20), phase=st.floats(0.0, 1.0), late=st.floats(0.0, 1.0))
def test_loop_that_sends_each_value_several_times_moves_in_no_pause(
    repeats: int, phase: float, late: float
) -> None:
    step = INTERVAL / repeats
    times = [step * (index + late) for index in range(27 * repeats)]
    values = [math.sin(math.floor(time / INTERVAL + phase)) for time in times]
    pauses = [INTERVAL * round(pause / INTERVAL) for pause in PAUSES]  # as long as full periods
    assert moved_in_pauses(Channel("/signal", "x", times, values), pauses) is not True


def test_constant_does_not_move() -> None:
    assert moved_in_pauses(record(lambda _: 1.0), PAUSES) is False


def test_few_messages_are_no_evidence() -> None:
    moved = record(with_pauses([True] * 3 + [False] * 5))
    # Of ten changes beside those of three pauses, but not of nine.
    assert moved_in_pauses(moved.between(0.0, 1.35), PAUSES[:3]) is True
    assert moved_in_pauses(moved.between(0.0, 1.25), PAUSES[:3]) is False
    moved = record(with_pauses([True] * 8))
    assert moved_in_pauses(moved.between(1.9), PAUSES) is False
    later = [5.0 + number for number in range(20)]  # without messages
    assert moved_in_pauses(moved, [*PAUSES, *later]) is False
