"""Presence of a robot."""

from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_interfaces_demo.monitoring.presence import TRANSITIONS, Attendance, Event, Presence

#: Ages at which a robot is stale and lost [s].
STALE_S, LOST_S = 3.0, 10.0
#: Intervals between arrivals, on both sides of both limits [s].
GAPS = st.lists(st.sampled_from([0.0, 1.0, 2.5, 3.0, 3.5, 9.0, 10.0, 10.5, 40.0]), max_size=12)


def after(gaps: List[float], looks_per_gap: int = 0) -> Attendance:
    """Return a robot that was heard once, and again after each gap."""
    attendance, now = Attendance(Presence.AWAITED, 0.0), 0.0
    attendance.add_message(now, STALE_S, LOST_S)
    for gap in gaps:
        for number in range(looks_per_gap):
            attendance.check_age(now + gap * number / looks_per_gap, STALE_S, LOST_S)
        now += gap
        attendance.add_message(now, STALE_S, LOST_S)
    return attendance


@given(GAPS)
def test_it_is_stale_then_lost_by_the_age_of_its_last_message(gaps: List[float]) -> None:
    attendance, now = after(gaps), sum(gaps)
    is_back = attendance.state
    assert is_back in (Presence.PRESENT, Presence.RETURNING)
    for age, state in (
        (3.0, is_back),
        (3.1, Presence.STALE),
        (10.0, Presence.STALE),
        (10.1, Presence.LOST),
    ):
        attendance.check_age(now + age, STALE_S, LOST_S)
        assert attendance.state is state
        assert attendance.age(now + age) == pytest.approx(age)


@given(GAPS)
def test_after_a_gap_it_has_to_be_heard_for_as_long_as_is_stale(gaps: List[float]) -> None:
    heard_for = sum(gaps)
    for index, gap in enumerate(gaps):
        if gap > STALE_S:
            heard_for = sum(gaps[index + 1 :])
    has_gap = max(gaps, default=0.0) > STALE_S
    settled = heard_for >= STALE_S or not has_gap
    assert after(gaps).state is (Presence.PRESENT if settled else Presence.RETURNING)


@given(GAPS, st.integers(1, 5))
def test_how_often_it_is_looked_at_makes_no_difference(gaps: List[float], looks: int) -> None:
    often, seldom = after(gaps, looks), after(gaps)
    assert often.state is seldom.state
    for age in (1.0, 4.0, 11.0):
        for attendance in (often, seldom):
            attendance.check_age(sum(gaps) + age, STALE_S, LOST_S)
        assert often.state is seldom.state


def test_awaited_robot_becomes_never_seen_or_present() -> None:
    attendance = Attendance(Presence.AWAITED, 5.0)
    attendance.check_age(8.0, STALE_S, LOST_S)
    assert attendance.state is Presence.AWAITED
    attendance.check_age(8.5, STALE_S, LOST_S)
    assert attendance.state is Presence.NEVER_SEEN
    attendance.check_age(100.0, STALE_S, LOST_S)
    assert attendance.state is Presence.NEVER_SEEN
    attendance.add_message(101.0, STALE_S, LOST_S)
    assert attendance.state is Presence.PRESENT


def test_all_states_are_reachable_without_self_transitions() -> None:
    assert {Presence.AWAITED, *TRANSITIONS.values()} == set(Presence)
    assert all(state is not goal for (state, _), goal in TRANSITIONS.items())
    assert {event for _, event in TRANSITIONS} == set(Event)
