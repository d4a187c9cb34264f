"""Rates and recent faults of topics, from counters."""

from typing import Dict, List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.health.topic_health import TopicCounts, TopicHealth, TopicHealthMonitor
from ros2_bridge.rules.selection import Route

A, B = Route("/a", True), Route("/b", False)


def states(*updates: Tuple[float, Dict[Route, TopicCounts]]) -> Dict[Route, TopicHealth]:
    """Return the states after several updates."""
    monitor = TopicHealthMonitor()
    found: List[Dict[Route, TopicHealth]] = [monitor.update(*update) for update in updates]
    return found[-1]


def test_rate_of_first_update_is_zero() -> None:
    assert states((5.0, {A: TopicCounts(100)}))[A].rate == 0.0


def test_rate_is_averaged_over_the_window() -> None:
    updates = [(float(second), {A: TopicCounts(10 * second)}) for second in range(20)]
    assert states(*updates)[A].rate == pytest.approx(10.0)
    stopped = [(20.0 + second, {A: TopicCounts(190)}) for second in range(8)]
    assert states(*updates, *stopped[:1])[A].rate == pytest.approx(8.0)
    assert states(*updates, *stopped)[A].rate == 0.0


def test_rate_of_later_topic_counts_from_its_first_update() -> None:
    updates = [(float(second), {B: TopicCounts(second)}) for second in range(4)]
    both = {B: TopicCounts(4), A: TopicCounts(7)}
    assert states(*updates, (4.0, both))[A].rate == 0.0
    later = {B: TopicCounts(5), A: TopicCounts(27)}
    found = states(*updates, (4.0, both), (5.0, later))
    assert found[A].rate == pytest.approx(20.0)
    assert found[B].rate == pytest.approx(1.0)


@given(st.lists(st.integers(0, 50), min_size=2, max_size=12))
def test_rate_times_time_is_what_was_passed(growths: List[int]) -> None:
    monitor, total, totals = TopicHealthMonitor(), 0, []
    for second, growth in enumerate(growths):
        total += growth
        totals.append(total)
        rate = monitor.update(float(second), {A: TopicCounts(total)})[A].rate
        first = max(0, second - 5)
        assert rate * (second - first) == pytest.approx(total - totals[first], abs=1e-9)


def test_rate_restarts_with_the_counters() -> None:
    before = [(float(second), {A: TopicCounts(100 * second, lost=9)}) for second in range(4)]
    found = states(*before, (4.0, {A: TopicCounts(3, lost=2)}))
    assert found[A].rate == 0.0
    assert found[A].recent == {"lost": 11}
    found = states(*before, (4.0, {A: TopicCounts(3)}), (5.0, {A: TopicCounts(13)}))
    assert found[A].rate == pytest.approx(10.0)


def test_rate_restarts_after_the_topic_was_closed() -> None:
    before = (0.0, {A: TopicCounts()}), (1.0, {A: TopicCounts(5, lost=2)}), (2.0, {})
    found = states(*before, (3.0, {A: TopicCounts(50)}))
    assert (found[A].rate, found[A].recent) == (0.0, {})


@pytest.mark.parametrize("name", ["lost", "refused", "unread"])
def test_fault_is_recent_for_ten_seconds(name: str) -> None:
    one, two = TopicCounts()._replace(**{name: 2}), TopicCounts()._replace(**{name: 5})
    assert states((0.0, {A: TopicCounts()}), (1.0, {A: one}))[A].recent == {name: 2}
    assert states((1.0, {A: one}), (5.0, {A: two}))[A].recent == {name: 5}
    assert states((1.0, {A: one}), (5.0, {A: two}), (11.5, {A: two}))[A].recent == {name: 3}
    assert states((1.0, {A: one}), (5.0, {A: two}), (15.0, {A: two}))[A].recent == {}


def test_thinned_messages_and_held_bytes_are_no_faults() -> None:
    found = states((0.0, {A: TopicCounts()}), (1.0, {A: TopicCounts(thinned=5, held=9)}))
    assert found[A].recent == {}


def test_disconnected_slow_subscriber_is_no_new_fault() -> None:
    updates = [(float(s), {A: TopicCounts(unread=n)}) for s, n in enumerate((8, 0, 1))]
    assert states(*updates)[A].recent == {"unread": 9}
