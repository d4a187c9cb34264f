"""The period is learnt from arrivals, and robust against outliers."""

from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_interfaces_demo.monitoring.period import LEAST_PERIOD_S, PeriodLearner

LONGEST_S = 10.0
PERIODS = st.floats(LEAST_PERIOD_S * 1.01, LONGEST_S / 1.2)
#: How much an interval is off, part of the period.
JITTER = st.lists(st.floats(-0.1, 0.1), min_size=9, max_size=20)


def learnt(*intervals: float) -> PeriodLearner:
    """Return the period learnt from arrivals."""
    learner, now = PeriodLearner(), 100.0
    learner.add_arrival(now, LONGEST_S)
    for interval in intervals:
        now += interval
        learner.add_arrival(now, LONGEST_S)
    return learner


@given(PERIODS, JITTER)
def test_period_is_learnt_from_nearly_regular_arrivals(period: float, jitter: List[float]) -> None:
    found = learnt(*(period * (1.0 + off) for off in jitter)).period(LONGEST_S)
    assert max(0.89 * period, LEAST_PERIOD_S) <= found <= 1.11 * period


@given(st.floats(0.2, 5.0), st.floats(0.0, 1e4), st.integers(0, 100), st.integers(2, 8))
def test_neither_a_gap_nor_a_burst_changes_it(
    period: float, gap: float, burst: int, before: int
) -> None:
    learner = learnt(*[period] * before, gap, *[0.0] * burst, *[period] * 2)
    assert learner.period(LONGEST_S) == pytest.approx(period)


@given(st.floats(0.2, 9.0), st.floats(0.2, 9.0))
def test_new_period_is_learnt(old: float, new: float) -> None:
    enough = 2 if new > old else 7
    assert learnt(*[old] * 20, *[new] * enough).period(LONGEST_S) == pytest.approx(new)
    not_yet = learnt(*[old] * 20, *[new] * (enough - 1))
    assert not_yet.period(LONGEST_S) == pytest.approx(old)


@pytest.mark.parametrize("intervals", [[], [1.0], [0.01] * 5, [11.0, 12.0, 13.0]])
def test_it_is_the_longest_until_two_intervals_are_known(intervals: List[float]) -> None:
    learner = learnt(*intervals)
    assert learner.period(LONGEST_S) == LONGEST_S
    assert learner.period(4.0) == 4.0


@given(st.floats(0.001, LEAST_PERIOD_S))
def test_faster_arrivals_count_as_least_period(period: float) -> None:
    assert learnt(*[period] * 200).period(LONGEST_S) == pytest.approx(LEAST_PERIOD_S)


def test_reduced_longest_period_applies_immediately() -> None:
    assert learnt(5.0, 5.0).period(LONGEST_S) == 5.0
    assert learnt(5.0, 5.0).period(2.0) == 2.0
    assert learnt(LONGEST_S, LONGEST_S).period(20.0) == LONGEST_S  # which is no absence
