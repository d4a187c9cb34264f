"""Tests of deadlines on an even grid, with lateness and changes of rate."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from nodekit.timing.timetable import SLACK_S, Timetable

#: Times of day, of a simulation and since 1970, s.
STARTS = st.floats(0.0, 1e5) | st.sampled_from([0.0, 1.7e9])
RATES = st.floats(0.01, 10000.0) | st.sampled_from([0.1, 1.0, 3.0, 10.0, 50.0, 100.0, 1000.0])
EVENTS = st.lists(
    st.one_of(
        st.tuples(st.just("wait"), st.floats(0.0, 1e3)),
        st.tuples(st.just("sleep"), st.floats(0.0, 3.0)),
        st.tuples(st.just("rate"), RATES),
        st.tuples(st.just("pause"), st.none()),
        st.tuples(st.just("back"), st.floats(0.001, 100.0)),
    ),
    max_size=30,
)


def run(timetable, start, events):
    """Live through events.

    :returns: for each call (time, deadline that was taken, time that passed for the task, how often
        the clock had been set back)
    """
    now, calls, backs = start, [], 0

    def take_if_due():
        deadline = timetable.deadline
        if deadline is not None and now >= deadline - SLACK_S:
            calls.append((now, deadline, timetable.take_deadline(now), backs))

    take_if_due()
    for event, amount in events:
        if event == "wait":
            deadline = timetable.deadline
            now = (now if deadline is None else max(now, deadline)) + amount * 1e-6
        elif event == "sleep":
            now += amount
        elif event == "rate":
            timetable.set_rate(amount)
        elif event == "pause":
            timetable.set_rate(0.0)
        else:
            now -= amount
            backs += 1
            timetable.restart(now)
        take_if_due()
    return calls


def test_first_call_is_due_immediately_with_zero_elapsed():
    timetable = Timetable(0.1)
    assert timetable.deadline == -math.inf
    timetable.begin(5.0)
    assert timetable.deadline == 5.0
    assert timetable.take_deadline(5.0) == 0.0
    assert timetable.deadline == 15.0
    assert timetable.skipped == 0


@given(STARTS, RATES, st.floats(0.0, 1e3))
def test_beginning_again_has_no_effect(start, rate, later):
    timetable = Timetable(rate)
    timetable.begin(start)
    timetable.begin(start + later)
    assert timetable.deadline == start
    assert timetable.take_deadline(start) == 0.0
    due = timetable.deadline
    timetable.begin(start + later)
    assert timetable.deadline == due


def test_the_first_call_that_is_late_counts_from_when_it_was_due():
    timetable = Timetable(10.0)
    timetable.begin(5.0)
    assert timetable.take_deadline(5.25) == pytest.approx(0.2)
    assert timetable.skipped == 2
    assert timetable.deadline == pytest.approx(5.3)


def test_taking_a_deadline_begins():
    timetable = Timetable(2.0)
    assert timetable.take_deadline(7.0) == 0.0
    assert timetable.deadline == 7.5


@given(STARTS, RATES, st.lists(st.floats(0.0, 0.9), max_size=50))
def test_late_calls_do_not_drift(start, rate, lateness):
    timetable = Timetable(rate)
    timetable.take_deadline(start)
    for number, late in enumerate(lateness, start=1):
        due = start + number / rate
        assert timetable.deadline == pytest.approx(due, rel=1e-15, abs=1e-15)
        assert timetable.take_deadline(due + late / rate) == pytest.approx(number / rate)


def test_a_day_at_1_khz_ends_on_the_very_grid():
    timetable = Timetable(1000.0)
    timetable.take_deadline(1.7e9)
    assert timetable.take_deadline(1.7e9 + 86400.0004) == 86400.0
    assert timetable.deadline == 1.7e9 + 86400.001


def test_missed_deadlines_are_caught_up_if_requested():
    timetable = Timetable(10.0, catch_up=0.5)
    timetable.take_deadline(0.0)
    assert [timetable.take_deadline(0.31) for _ in range(3)] == pytest.approx([0.1, 0.2, 0.3])
    assert timetable.deadline == pytest.approx(0.4)
    assert timetable.skipped == 0


def test_calls_missed_by_too_much_are_not_caught_up():
    timetable = Timetable(10.0, catch_up=0.5)
    timetable.take_deadline(0.0)
    assert timetable.take_deadline(60.05) == pytest.approx(60.0)
    assert timetable.deadline == pytest.approx(60.1)
    assert timetable.skipped == 599


def test_missed_deadlines_are_skipped_and_the_grid_is_kept():
    timetable = Timetable(10.0)
    timetable.take_deadline(0.0)
    assert timetable.take_deadline(0.57) == 0.5
    assert timetable.deadline == 0.6
    assert timetable.skipped == 4
    assert timetable.take_deadline(0.6) == 0.6
    assert timetable.skipped == 4
    assert timetable.take_deadline(0.85) == 0.8
    assert timetable.skipped == 5


@given(STARTS, st.floats(0.1, 1000.0), st.lists(st.floats(0.0, 50.0), max_size=20))
def test_missed_deadlines_are_skipped_and_counted(start, rate, waits):
    timetable = Timetable(rate)
    now = start
    timetable.begin(now)
    taken = [timetable.take_deadline(now)]
    for periods in waits:
        now = max(now, timetable.deadline) + periods / rate
        taken.append(timetable.take_deadline(now))
    number = round(taken[-1] * rate)
    assert len(taken) + timetable.skipped == number + 1


@given(STARTS, RATES, EVENTS)
def test_time_never_runs_back_for_the_task(start, rate, events):
    calls = run(Timetable(rate), start, events)
    elapsed = [call[2] for call in calls]
    assert elapsed[0] == 0.0
    assert all(earlier < later for earlier, later in zip(elapsed, elapsed[1:]))


@given(STARTS, RATES, EVENTS)
@example(0.0, 0.1, [("wait", 0.0), ("sleep", 1.0), ("back", 1.0)])
def test_at_most_one_call_at_a_time(start, rate, events):
    calls = run(Timetable(rate), start, events)
    times = [(now, backs) for now, _, _, backs in calls]
    assert all(earlier != later for earlier, later in zip(times, times[1:]))


@given(STARTS, RATES, st.lists(RATES, min_size=1, max_size=5), st.floats(0.0, 200.0))
def test_new_rate_counts_from_the_last_call(start, rate, rates, waited):
    timetable = Timetable(rate)
    timetable.take_deadline(start)
    now = start + min(waited, 0.99 / rate)
    for latest in rates:
        timetable.set_rate(latest)
    next_one = start + 1.0 / rates[-1]
    assert timetable.deadline == pytest.approx(next_one, rel=1e-15, abs=1e-12)
    if now >= next_one:
        assert timetable.take_deadline(now) == pytest.approx(
            now - start, abs=1.0 / rates[-1] + SLACK_S
        )


def test_slow_task_that_becomes_quick_runs_immediately_and_loses_no_time():
    timetable = Timetable(0.1)
    timetable.take_deadline(100.0)
    timetable.set_rate(0.2)
    timetable.set_rate(50.0)
    assert timetable.deadline <= 107.003
    assert timetable.take_deadline(107.003) == pytest.approx(7.0)
    assert timetable.deadline == pytest.approx(107.02)


def test_rate_that_changes_after_some_calls_counts_from_the_last_of_them():
    timetable = Timetable(10.0)
    for now in (7.0, 7.1, 7.2):
        timetable.take_deadline(now)
    timetable.set_rate(4.0)
    assert timetable.deadline == pytest.approx(7.45)
    assert timetable.take_deadline(7.45) == pytest.approx(0.45)


def test_rate_that_changes_before_the_first_call():
    timetable = Timetable(0.1)
    timetable.set_rate(5.0)
    timetable.begin(3.0)
    assert timetable.deadline == 3.0
    timetable.set_rate(2.0)
    assert timetable.deadline == 3.0
    assert timetable.take_deadline(3.0) == 0.0
    assert timetable.deadline == 3.5


def test_a_pause_has_no_deadline_and_counts_as_time():
    timetable = Timetable(10.0)
    timetable.begin(70.0)
    timetable.take_deadline(70.0)
    timetable.set_rate(0.0)
    assert timetable.deadline is None
    timetable.set_rate(10.0)
    assert timetable.deadline == pytest.approx(70.1), "the grid is the old one"
    assert timetable.take_deadline(75.0) == pytest.approx(5.0)
    assert timetable.deadline == pytest.approx(75.1)


@pytest.mark.parametrize("rate", [1.0, 10.0, 20.0])
def test_a_pause_ends_with_any_rate(rate):
    timetable = Timetable(10.0)
    timetable.take_deadline(70.0)
    timetable.set_rate(0.0)
    timetable.set_rate(rate)
    assert timetable.deadline == pytest.approx(70.0 + 1.0 / rate)


@pytest.mark.parametrize("catch_up", [0.0, 60.0])
def test_calls_not_due_at_the_former_rate_are_not_skipped(catch_up):
    paused = Timetable(10.0, catch_up)
    paused.take_deadline(70.0)
    paused.set_rate(0.0)
    paused.set_rate(10.0)
    assert paused.take_deadline(75.0) == pytest.approx(5.0)
    assert paused.skipped == 0
    assert paused.take_deadline(75.35) == pytest.approx(5.1 if catch_up else 5.3)
    assert paused.skipped == (0 if catch_up else 2)
    slow = Timetable(0.1, catch_up)
    slow.take_deadline(100.0)
    slow.set_rate(50.0)
    assert slow.take_deadline(107.003) == pytest.approx(7.0)
    assert slow.deadline == pytest.approx(107.02)
    assert slow.skipped == 0


def test_the_same_rate_again_keeps_the_calls_to_catch_up():
    # All timers of a node are given their rates again after a change of any of its parameters.
    timetable = Timetable(10.0, catch_up=1.0)
    timetable.take_deadline(0.0)
    assert timetable.take_deadline(0.55) == pytest.approx(0.1)
    timetable.set_rate(10.0)
    assert timetable.deadline == pytest.approx(0.2)
    assert [timetable.take_deadline(0.55) for _ in range(4)] == pytest.approx([0.2, 0.3, 0.4, 0.5])
    assert timetable.skipped == 0


@pytest.mark.parametrize("rate", [0.0, 10.0])
def test_timetable_paused_from_the_start_begins_afterwards(rate):
    timetable = Timetable(rate)
    timetable.set_rate(0.0)
    assert timetable.deadline is None
    timetable.set_rate(4.0)
    assert timetable.deadline == -math.inf
    timetable.begin(9.0)
    assert timetable.take_deadline(9.0) == 0.0
    assert timetable.deadline == 9.25
    assert timetable.skipped == 0


def test_clock_set_back_during_a_pause():
    timetable = Timetable(10.0)
    for now in (50.0, 50.1):
        timetable.take_deadline(now)
    timetable.set_rate(0.0)
    timetable.restart(20.0)
    assert timetable.deadline is None
    timetable.set_rate(5.0)
    assert timetable.deadline == 20.0
    assert timetable.take_deadline(20.0) == pytest.approx(0.2)
    assert timetable.take_deadline(20.2) == pytest.approx(0.4)


@given(st.floats(10.0, 1e5), st.floats(0.5, 100.0), st.integers(0, 20), st.floats(0.1, 1e5))
def test_clock_set_back_schedules_the_task_with_one_period_elapsed(start, rate, calls, back):
    timetable = Timetable(rate)
    for number in range(calls):
        timetable.take_deadline(start + number / rate)
    now = start - back
    timetable.restart(now)
    assert timetable.deadline == now
    assert timetable.take_deadline(now) == pytest.approx(calls / rate)
    assert timetable.take_deadline(now + 1.0 / rate) == pytest.approx((calls + 1) / rate)


@given(
    st.sampled_from([10, 25, 50, 100, 250, 1000]),
    st.integers(0, 10**6) | st.integers(17 * 10**11, 18 * 10**11),
    st.sampled_from([1, 2, 5]),
)
def test_clock_steps_equal_to_the_deadlines_skip_none(hertz, first_ms, every):
    # The stamps of /clock are rounded to a float; so are the deadlines, but not alike.
    timetable = Timetable(hertz / every)
    stamps = [(first_ms * 1000 + number * (10**6 // hertz)) / 1e6 for number in range(200)]
    taken = 0
    for stamp in stamps:
        if timetable.deadline <= stamp + SLACK_S:
            timetable.take_deadline(stamp)
            taken += 1
    assert taken == 200 // every


@given(STARTS, RATES)
def test_rate_above_the_clocks_means_one_call_a_step(start, clock_rate):
    timetable = Timetable(20000.0)
    for number in range(50):
        now = start + number * max(1.0 / clock_rate, 0.001)
        assert timetable.deadline <= now + SLACK_S
        timetable.take_deadline(now)
        assert timetable.deadline > now + SLACK_S
