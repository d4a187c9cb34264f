"""Detection of late samples."""

import math
from typing import List, NamedTuple, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.conditioning.lateness import LATE_S, SETTLED_S, LatenessMonitor

PERIOD = 0.1
#: Receiver's clock at the beginning of the signal; arbitrary.
BEGIN = 7000.0


class Sample(NamedTuple):
    time_x: float


def feed(monitor: LatenessMonitor, now: float, times: List[float]) -> None:
    """Feed samples to a monitor; check whether it reports a change."""
    was_late = monitor.is_late
    changes = monitor.update(now, [Sample(time_x) for time_x in times])
    assert changes == (monitor.is_late != was_late)


def steady(begin: float, end: float) -> List[Tuple[float, List[float]]]:
    """Return (arrival, times) of single, timely samples."""
    count = round((end - begin) / PERIOD)
    times = [begin + n * PERIOD for n in range(count)]
    return [(BEGIN + time_x, [time_x]) for time_x in times]


def fed(*parts: List[Tuple[float, List[float]]]) -> LatenessMonitor:
    """Return a monitor that has taken in all parts."""
    monitor = LatenessMonitor()
    for part in parts:
        for now, times in part:
            feed(monitor, now, times)
    return monitor


def was_ever_late(*parts: List[Tuple[float, List[float]]]) -> bool:
    """Return whether any batch was detected as late."""
    monitor = LatenessMonitor()
    late = False
    for part in parts:
        for now, times in part:
            feed(monitor, now, times)
            late |= monitor.is_late
    return late


def held_back(begin: float, end: float) -> List[float]:
    """Return the times of samples that a broken link holds back."""
    return [times[0] for _, times in steady(begin, end)]


def test_no_samples_are_not_late() -> None:
    monitor = LatenessMonitor()
    assert (monitor.is_late, monitor.count, monitor.worst) == (False, 0, 0.0)


def test_first_samples_before_simulated_clock_are_not_late() -> None:
    monitor = fed([(0.0, [0.0]), (0.0, [0.1]), (BEGIN + 0.2, [0.2]), (BEGIN + 0.3, [0.3])])
    assert (monitor.is_late, monitor.worst) == (False, 0.0)
    feed(monitor, BEGIN + 0.4 + LATE_S, [0.4])
    assert monitor.is_late


def test_lateness_starts_and_ends_at_bounds() -> None:
    monitor = fed([(BEGIN, [0.0])])
    feed(monitor, BEGIN + 1.0 + LATE_S, [1.0])
    assert (monitor.is_late, monitor.count, monitor.worst) == (True, 1, LATE_S)
    feed(monitor, BEGIN + 1.0 + LATE_S + SETTLED_S, [1.0 + SETTLED_S])
    assert monitor.is_late
    feed(monitor, BEGIN + 1.5 + LATE_S + SETTLED_S, [1.5 + SETTLED_S])
    assert not monitor.is_late


def test_lag_of_a_batch_is_that_of_its_last_sample() -> None:
    monitor = fed(steady(0.0, 5.0), [(BEGIN + 5.9, held_back(5.0, 5.9))])
    feed(monitor, BEGIN + 7.1, [5.9])
    assert monitor.worst == pytest.approx(1.1)


@given(st.floats(1.5, 1e4))
def test_samples_held_back_are_late_by_as_long(outage: float) -> None:
    monitor = fed(steady(0.0, 5.0))
    feed(monitor, BEGIN + 5.0 + outage, [5.0])
    assert monitor.is_late
    assert monitor.worst == pytest.approx(outage)


def test_only_those_that_are_late_are_counted() -> None:
    burst = held_back(5.0, 25.0)
    monitor = fed(steady(0.0, 5.0), [(BEGIN + 25.04, burst[:50]), (BEGIN + 25.05, burst[50:])])
    assert monitor.is_late
    assert monitor.count == len([time_x for time_x in burst if 25.05 - time_x >= LATE_S])
    assert monitor.worst == pytest.approx(20.04)


def test_lateness_ends_after_burst() -> None:
    burst = held_back(5.0, 25.0)
    monitor = fed(steady(0.0, 5.0), [(BEGIN + 25.0, burst)], steady(25.1, 26.0))
    assert not monitor.is_late
    assert monitor.worst == pytest.approx(20.0)


def test_a_second_outage_is_counted_by_itself() -> None:
    monitor = fed(
        steady(0.0, 5.0),
        [(BEGIN + 25.0, held_back(5.0, 25.0))],
        steady(25.1, 30.0),
        [(BEGIN + 33.0, held_back(30.0, 33.0))],
    )
    assert monitor.worst == pytest.approx(3.0, abs=1e-6)
    assert monitor.count < 30


@given(st.floats(0.0, 0.95))
def test_a_busy_moment_is_no_lateness(pause: float) -> None:
    late = [(BEGIN + 5.0 + pause, held_back(5.0, 5.0 + pause + PERIOD))]
    assert not was_ever_late(steady(0.0, 5.0), late)


@given(st.floats(0.02, 50.0))
def test_bag_played_at_other_speed_is_not_late(speed: float) -> None:
    if PERIOD / speed - PERIOD < LATE_S:
        samples = [(n * PERIOD / speed, [n * PERIOD]) for n in range(300)]
        assert not was_ever_late(samples)


@given(st.floats(0.0, 1e5))
def test_a_change_of_rate_is_no_lateness(period: float) -> None:
    slow = [(BEGIN + 5.0 + n * period, [5.0 + n * period]) for n in range(4)]
    assert not was_ever_late(steady(0.0, 5.0), slow)


def test_resumed_signal_is_not_late() -> None:
    standing = [(BEGIN + 5.0 + n * PERIOD, [4.9]) for n in range(300)]
    on = [(now + 30.0, times) for now, times in steady(5.0, 6.0)]
    assert not was_ever_late(steady(0.0, 5.0), standing, on)


def test_stopped_signal_is_not_late_at_any_rate() -> None:
    assert not was_ever_late(steady(0.0, 5.0), [(BEGIN + 9.0, [4.9]), (BEGIN + 19.0, [4.9])])


def test_a_signal_that_begins_restarted_is_in_time() -> None:
    restarted = [(now + 60.0, times) for now, times in steady(0.0, 10.0)]
    assert not was_ever_late(steady(0.0, 5.0), restarted)


def test_a_signal_that_jumps_ahead_is_in_time() -> None:
    ahead = [(now - 100.0, times) for now, times in steady(105.0, 110.0)]
    assert not was_ever_late(steady(0.0, 5.0), ahead)


@given(st.floats(1.5, 1e6), st.integers(1, 40))
def test_clock_jump_after_signal_jump_is_not_late(jump: float, behind: int) -> None:
    samples = [(BEGIN + time_x, [jump + time_x]) for time_x in held_back(5.0, 10.0)]
    on = [(now + jump, times) for now, times in samples[behind:]]
    assert not was_ever_late(steady(0.0, 5.0), samples[:behind], on)


@given(st.floats(1.5, 1e6))
def test_clock_jump_before_signal_jump_is_not_late(jump: float) -> None:
    on = [(now + jump, [times[0] + jump]) for now, times in steady(5.0, 10.0)]
    assert not was_ever_late(steady(0.0, 5.0), on)


def test_lateness_by_jump_ends_with_first_timely_sample() -> None:
    jumped = [(now, [times[0] + 4.0]) for now, times in steady(5.0, 6.0)]
    monitor = fed(steady(0.0, 5.0), jumped)
    feed(monitor, BEGIN + 8.0, [10.0])  # half of what the clock will jump
    assert monitor.is_late
    feed(monitor, BEGIN + 10.1, [10.1])
    assert not monitor.is_late


def test_alternating_jumps_are_not_late() -> None:
    steps = [(BEGIN + 2.0 * (n - n % 2), [2.0 * n]) for n in range(50)]
    assert not was_ever_late(steps)


@pytest.mark.parametrize("outage", [20.0, 98.0, 102.0, 500.0])
def test_an_outage_after_a_jump_of_the_signal_alone_is_noticed(outage: float) -> None:
    ahead = [(now - 100.0, times) for now, times in steady(105.0, 108.0)]
    monitor = fed(steady(0.0, 5.0), ahead)
    feed(monitor, BEGIN + 8.0 + outage, [108.0])
    assert monitor.is_late
    assert monitor.worst == pytest.approx(outage)


def test_jump_is_forgotten_after_some_time() -> None:
    ahead = [(now - 100.0, times) for now, times in steady(105.0, 105.2 + SETTLED_S)]
    monitor = fed(steady(0.0, 5.0), ahead)
    time_x = 105.3 + SETTLED_S
    feed(monitor, BEGIN + time_x, [time_x])
    assert monitor.is_late


def test_permanent_lag_becomes_normal() -> None:
    def later(end: float) -> List[Tuple[float, List[float]]]:
        return [(now + 30.0, times) for now, times in steady(5.0, end)]

    assert fed(steady(0.0, 5.0), later(5.0 + 0.9 * SETTLED_S)).is_late
    assert not fed(steady(0.0, 5.0), later(5.0 + 1.1 * SETTLED_S)).is_late


def test_the_first_sample_is_in_time() -> None:
    assert not fed([(1e9, [12.0])]).is_late


@pytest.mark.parametrize("time_x", [math.nan, math.inf, -math.inf])
def test_a_time_that_is_no_number_is_passed_over(time_x: float) -> None:
    nonsense = [(BEGIN + 5.0, [time_x])]
    assert not was_ever_late(steady(0.0, 5.0), nonsense, steady(5.1, 6.0))
    assert fed(steady(0.0, 5.0), nonsense, [(BEGIN + 9.0, [5.0])]).is_late
