"""Dead man's switch: commands time out with one zero, then silence."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.robots.dead_man import HOLD_S, STOP, DeadMan, Velocity

AHEAD = Velocity(0.2, 0.0)


def test_timeout_sends_one_zero_and_then_nothing() -> None:
    switch = DeadMan()
    assert switch.until is None and switch.expire(0.0) is None
    assert switch.accept(AHEAD, 100.0, 1.0) == AHEAD
    assert switch.expire(1.0 + HOLD_S - 1e-6) is None
    assert switch.expire(switch.until or 0.0) == STOP
    assert switch.until is None
    assert [switch.expire(1.0 + n) for n in range(5)] == [None] * 5


def test_release_stops_immediately_and_once() -> None:
    switch = DeadMan()
    switch.accept(AHEAD, 100.0, 1.0)
    assert switch.accept(STOP, 100.1, 1.1) == STOP
    assert switch.expire(9.0) is None and switch.stop() is None
    switch.accept(AHEAD, 102.0, 3.0)
    assert switch.stop() == STOP and switch.stop() is None and switch.expire(9.0) is None


def test_hold_time_is_within_the_documented_limit() -> None:
    assert 0.1 < HOLD_S < 0.25  # at most 0.3 s in all; a page repeats a command each 0.05 s


def test_delayed_commands_are_ignored() -> None:
    switch = DeadMan()
    for n in range(20):
        assert switch.accept(AHEAD, 100.0 + 0.05 * n, 1.0 + 0.05 * n) == AHEAD
    # The link stalls for 2 s; then all commands arrive together.
    assert switch.expire(3.9) == STOP
    late = [switch.accept(AHEAD, 101.0 + 0.05 * n, 4.0) for n in range(40)]
    assert late[:36] == [None] * 36 and late[-1] == AHEAD
    # A link with a delay of half a second is unfit for driving.
    assert switch.expire(5.0) == STOP
    assert {switch.accept(AHEAD, 103.0 + 0.05 * n, 6.5 + 0.05 * n) for n in range(40)} == {None}
    assert switch.accept(STOP, 105.0, 8.5) is None


def test_late_zero_stops_a_moving_robot() -> None:
    switch = DeadMan()
    switch.accept(AHEAD, 100.0, 1.0)
    switch.accept(AHEAD, 101.0, 2.0)
    assert switch.accept(STOP, 100.5, 2.1) == STOP


@pytest.mark.parametrize("drift", (-1e-4, 1e-4))
def test_clock_drift_is_tolerated(drift: float) -> None:
    switch = DeadMan()
    for minute in range(600):
        now = 60.0 * minute
        assert switch.accept(AHEAD, now * (1.0 + drift), now) == AHEAD


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.booleans()), max_size=50))
def test_robot_never_moves_longer_than_the_hold_time(steps: list) -> None:
    """If each due zero is sent, no command is in force for longer than HOLD_S."""
    switch, now, moving_since = DeadMan(), 0.0, None
    for pause, is_stop in steps:
        due = switch.until
        if due is not None and due <= now + pause:
            assert moving_since is not None and due - moving_since <= HOLD_S + 1e-9
            assert switch.expire(due) == STOP
            moving_since = None
        now += pause
        reply = switch.accept(STOP if is_stop else AHEAD, now, now)
        moving_since = now if reply == AHEAD else None
        assert (switch.until is None) == (moving_since is None)
