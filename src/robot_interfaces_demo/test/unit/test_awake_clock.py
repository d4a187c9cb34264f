"""Time that may be held against robots."""

from typing import List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_interfaces_demo.monitoring.awake_clock import AwakeClock


def read(*times: Tuple[float, float]) -> AwakeClock:
    """Return a clock that was read at moments of ROS's and of the machine's time."""
    clock = AwakeClock(interval_s=0.5)
    for now, machine in times:
        clock.read(now, machine)
    return clock


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
def test_it_goes_with_the_machine_s_clock(steps: List[float]) -> None:
    moments = [1000.0 + sum(steps[:number]) for number in range(len(steps) + 1)]
    clock = read(*zip(moments, moments))
    assert clock.time == pytest.approx(sum(steps))


def test_suspended_process_counts_as_timely_reading() -> None:
    assert read((10.0, 10.0), (610.0, 610.0)).time == pytest.approx(0.5)
    assert read((10.0, 10.0), (11.1, 11.1), (11.2, 11.2)).time == pytest.approx(0.6)
    # Simulated time may be quicker or slower than the machine's.
    assert read((10.0, 10.0), (70.0, 40.0)).time == pytest.approx(1.0)
    assert read((10.0, 10.0), (25.0, 40.0)).time == pytest.approx(0.25)


def test_simulated_time_may_stop_or_jump() -> None:
    assert read((5.0, 0.0), (5.0, 1.0), (5.0, 1.9), (5.5, 2.0)).time == 0.5
    assert read((5.0, 0.0), (2.0, 0.2), (2.5, 0.4)).time == 0.5  # set back
    assert read((0.0, 0.0), (1.7e9, 0.2), (1.7e9 + 0.5, 0.4)).time == 0.5  # the first /clock
    assert read((5.0, 0.0), (15.0, 0.2)).time == 10.0
    assert read((5.0, 0.0), (15.5, 0.2)).time == 0.0


def test_duration_of_stopped_clock() -> None:
    assert read((5.0, 1.0)).still_s == 0.0
    assert read((5.0, 1.0), (5.0, 2.0), (5.0, 4.0)).still_s == 3.0
    assert read((5.0, 1.0), (5.0, 4.0), (5.1, 4.5), (5.1, 5.0)).still_s == 0.5
    assert read((5.0, 1.0), (5.0, 4.0), (4.0, 4.5)).still_s == 0.0


@given(st.lists(st.tuples(st.floats(-1e9, 1e9), st.floats(0.0, 1e4)), min_size=1))
def test_it_never_goes_back_nor_further_than_a_jump(steps: List[Tuple[float, float]]) -> None:
    clock, machine, before = AwakeClock(interval_s=0.5), 0.0, 0.0
    for now, step in steps:
        machine += step
        time = clock.read(now, machine)
        assert before <= time <= before + 10.0
        before = time
