"""What is missing in a stream is found, and how long it was silent."""

import math
from typing import List

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ci.endurance.streams import Arrivals, Continuity, unanswered

PERIOD = 1e-3


def fed(times: List[float]) -> Continuity:
    """Return the continuity of a series of sample times."""
    continuity = Continuity(PERIOD)
    for time_x in times:
        continuity.add(time_x)
    return continuity


@settings(max_examples=30)
@given(st.sets(st.integers(1, 998)), st.floats(0.0, 1e5))
def test_each_missing_sample_is_counted(removed: "set[int]", begin: float) -> None:
    times = [begin + n * PERIOD for n in range(1000) if n not in removed]
    assert fed(times).missing == len(removed)


def test_jitter_is_no_hole() -> None:
    continuity = fed([n * PERIOD + 3e-4 * math.sin(n) for n in range(1000)])
    assert (continuity.missing, continuity.repeated) == (0, 0)


def test_a_repeated_sample_is_no_missing_one() -> None:
    continuity = fed([0.0, PERIOD, PERIOD, 2 * PERIOD])
    assert (continuity.missing, continuity.repeated) == (0, 1)


def test_silences_are_measured_and_those_above_50_ms_counted() -> None:
    arrivals = Arrivals()
    for moment in (1.0, 1.04, 1.1, 1.5, 1.51):
        arrivals.add(moment, messages=2)
    assert arrivals.count == 10
    assert arrivals.longest_gap == pytest.approx(0.4)
    assert str(arrivals) == "400.0 ms at most, 2 above 50 ms"


ANSWERS = [math.cos(1e-3 * n) for n in range(9000)]


@pytest.mark.parametrize("late", [0, 1, 7, 399])
def test_lists_may_begin_and_end_before_each_other(late: int) -> None:
    assert unanswered(ANSWERS, ANSWERS[late:]) == 0
    assert unanswered(ANSWERS[late:], ANSWERS) == 0
    assert unanswered(ANSWERS, ANSWERS[: len(ANSWERS) - late]) == 0
    assert unanswered(ANSWERS[: len(ANSWERS) - late], ANSWERS[late:]) == 0


@settings(max_examples=20)
@given(st.sets(st.integers(2000, 7000), max_size=50), st.integers(0, 300))
def test_each_missing_answer_is_counted(removed: "set[int]", late: int) -> None:
    answers = [answer for n, answer in enumerate(ANSWERS) if n not in removed]
    assert unanswered(ANSWERS, answers[late:]) == len(removed)


def test_answers_to_something_else_are_refused() -> None:
    with pytest.raises(ValueError, match="do not belong"):
        unanswered(ANSWERS, [0.5 + answer for answer in ANSWERS])


def test_no_answers_at_all_are_refused() -> None:
    with pytest.raises(ValueError, match="do not belong"):
        unanswered(ANSWERS, [])
