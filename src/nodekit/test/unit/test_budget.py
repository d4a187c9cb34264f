"""How often something may be done: writers that correct each other must not hurry."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.parameters.budget import BURST, REFILL_S, Budget


def test_a_burst_goes_at_once_and_more_one_by_one():
    budget = Budget()
    assert [budget.allow("level", 0.0) for _ in range(BURST)] == [True] * BURST
    assert not budget.allow("level", 0.5 * REFILL_S)
    assert budget.allow("title", 0.5 * REFILL_S)
    assert budget.allow("level", 1.1 * REFILL_S)
    assert not budget.allow("level", 1.9 * REFILL_S)


def test_one_more_goes_with_each_of_the_questions_that_come_once_in_a_while():
    budget = Budget()
    for _ in range(BURST):
        budget.allow("level", 0.0)
    assert all(budget.allow("level", number * REFILL_S) for number in range(1, 1000))


@given(st.lists(st.floats(0.0, 3.0 * REFILL_S), max_size=200))
def test_never_more_is_allowed_than_the_burst_and_one_a_period(pauses):
    budget, now, allowed = Budget(), 0.0, 0
    for pause in pauses:
        now += pause
        allowed += budget.allow("level", now)
        assert allowed <= BURST + now / REFILL_S + 1e-6


@pytest.mark.parametrize("rest", [BURST * REFILL_S, 1e6])
def test_the_burst_is_back_after_a_rest(rest):
    budget = Budget()
    for _ in range(2 * BURST):
        budget.allow("level", 0.0)
    assert [budget.allow("level", rest) for _ in range(BURST + 1)].count(True) == BURST
