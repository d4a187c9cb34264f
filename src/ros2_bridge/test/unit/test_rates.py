"""Messages are limited to a maximum rate, and reach it."""

import math
from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.rules.rates import MaxRates, RateLimit


def test_first_rule_that_matches_counts() -> None:
    rates = MaxRates(["/camera/left=2.5", "/camera/*=10", "/a=b=1e-3"])
    assert rates.of("/camera/left") == 2.5
    assert rates.of("/camera/right") == 10.0
    assert rates.of("/a=b") == 0.001
    assert rates.of("/tf") == math.inf


@pytest.mark.parametrize("rule", ["/a", "/a=", "=5", "/a=0", "/a=-1", "/a=nan", "/a=inf", "/a=b"])
def test_malformed_rule_is_refused(rule: str) -> None:
    with pytest.raises(ValueError, match=f"such as /camera/.=10; '{rule}' is not"):
        MaxRates(["/b=1", rule])


def passed(rate: float, times: List[float]) -> List[float]:
    limit = RateLimit()
    limit.set_rate(rate)
    return [now for now in times if limit.passes(now)]


def test_without_a_limit_all_pass() -> None:
    assert passed(math.inf, [0.0, 0.0, 1.0]) == [0.0, 0.0, 1.0]


@given(st.lists(st.floats(0.0, 100.0)), st.floats(0.1, 50.0))
def test_never_more_pass_than_may(times: List[float], rate: float) -> None:
    found = passed(rate, sorted(times))
    for first, begin in enumerate(found):
        for last in range(first, len(found)):
            assert last - first <= (found[last] - begin) * rate + 1 + 1e-6


@given(st.floats(1.0, 29.0))
def test_messages_at_30_hz_pass_at_maximum_rate(rate: float) -> None:
    found = passed(rate, [number / 30.0 for number in range(3000)])
    assert len(found) == pytest.approx(100.0 * rate, abs=1.5)


def test_no_burst_after_a_pause() -> None:
    assert passed(10.0, [0.0, 50.0, 50.05, 50.1, 50.15]) == [0.0, 50.0, 50.1]


def test_removed_limit_passes_all() -> None:
    limit = RateLimit()
    limit.set_rate(0.1)
    assert limit.passes(0.0) and not limit.passes(1.0)
    limit.set_rate(0.1)
    assert not limit.passes(1.0)
    limit.set_rate(math.inf)
    assert limit.passes(1.0) and limit.passes(1.0)
