"""History of the statistics: each time span is counted once."""

import math
import statistics
from typing import Any, Dict, List

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.page.statistics_history import StatisticsHistory, Variation

numbers = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=50)


@settings(max_examples=30)
@given(numbers, st.sampled_from([0.0, 1e9]))
def test_variation_equals_the_statistics_of_all_numbers(values: List[float], middle: float) -> None:
    variation, values = Variation(), [middle + value for value in values]
    for value in values:
        variation.add(value)
    sigma = pytest.approx(statistics.pstdev(values), rel=1e-6, abs=1e-6)
    assert variation.summary == {
        "mean": pytest.approx(statistics.fmean(values), rel=1e-12, abs=1e-9),
        "sigma": sigma,
        "min": min(values),
        "max": max(values),
        "count": len(values),
    }


def counted(over: StatisticsHistory, number: int, end: float, **figures: Any) -> Dict[str, Any]:
    traces = {"/a": dict(figures)}
    over.count(number, (end - 1.0, end), traces)
    found: Dict[str, Any] = traces["/a"].get("over_time", {})
    return found


def test_each_span_counts_once_until_another_request_restarts() -> None:
    over = StatisticsHistory()
    assert counted(over, 0, 1.0, mean=1.0) == {}
    assert counted(over, 1, 1.0, mean=1.0, problem=None, topic="/a", nan=0.5) == {
        "mean": {"mean": 1.0, "sigma": 0.0, "min": 1.0, "max": 1.0, "count": 1}
    }
    assert counted(over, 1, 1.0, mean=7.0)["mean"]["count"] == 1  # the page is paused
    found = counted(over, 1, 1.25, mean=3.0, frequency=None, max=math.inf)
    assert found == {"mean": {"mean": 2.0, "sigma": 1.0, "min": 1.0, "max": 3.0, "count": 2}}
    assert counted(over, 1, 1.5, mean=math.nan, rise=0.1)["rise"]["count"] == 1
    assert counted(over, 2, 1.5, mean=5.0)["mean"]["count"] == 1
    assert counted(over, 0, 1.75, mean=5.0) == {}


def test_dropped_trace_restarts_even_on_a_paused_page() -> None:
    over = StatisticsHistory()
    assert counted(over, 1, 1.0, mean=1.0)["mean"]["count"] == 1
    over.forget(["/b"])
    assert counted(over, 1, 2.0, mean=2.0)["mean"]["count"] == 2
    over.forget(["/a"])
    for _ in range(2):
        assert counted(over, 1, 2.0, mean=8.0) == {
            "mean": {"mean": 8.0, "sigma": 0.0, "min": 8.0, "max": 8.0, "count": 1}
        }
