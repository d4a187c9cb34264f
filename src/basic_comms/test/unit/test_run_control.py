"""When a signal runs: start, delay, stop, end, reset and a clock that is set back."""

from hypothesis import given
from hypothesis import strategies as st

from basic_comms.signals.run_control import RunControl


def states(control, readings, start_delay=0.0, duration=0.0):
    """Return the control's status at readings of the clock, as texts."""
    return [str(control.at(reading, start_delay, duration)) for reading in readings]


def test_time_starts_at_the_first_reading():
    control = RunControl()
    assert states(control, [100.0, 100.5, 103.0]) == [
        "running 0.000",
        "running 0.500",
        "running 3.000",
    ]


def test_time_is_the_plain_difference_of_the_clock():
    control = RunControl()
    control.at(0.1, 0.0, 0.0)
    assert control.at(1e9 + 0.3, 0.0, 0.0).time_x == (1e9 + 0.3) - 0.1


def test_a_stopped_signal_keeps_its_time_and_continues_from_there():
    control = RunControl()
    states(control, [10.0, 12.0])
    control.enable(12.5, False)
    assert states(control, [13.0, 20.0]) == ["idle 2.500", "idle 2.500"]
    control.enable(30.0, True)
    assert states(control, [30.25, 31.0]) == ["running 2.750", "running 3.500"]


def test_a_sample_that_was_due_before_enable_does_not_take_the_time_back():
    control = RunControl()
    states(control, [10.0])
    control.enable(12.0, False)
    control.enable(15.5, True)
    assert states(control, [15.4, 16.5]) == ["running 2.000", "running 3.100"]


def test_repeated_enable_or_stop_has_no_effect():
    control = RunControl()
    states(control, [10.0])
    control.enable(11.0, True)
    assert states(control, [12.0]) == ["running 2.000"]
    control.enable(12.0, False)
    control.enable(13.0, False)
    assert states(control, [14.0]) == ["idle 2.000"]


def test_without_autostart_it_waits_for_enable():
    control = RunControl(enabled=False)
    assert states(control, [10.0, 11.0]) == ["idle 0.000", "idle 0.000"]
    control.enable(12.0, True)
    assert states(control, [12.5]) == ["running 0.500"]


def test_time_starts_after_start_delay():
    control = RunControl()
    assert states(control, [10.0, 11.0, 12.0, 13.0], start_delay=2.0) == [
        "idle 0.000",
        "idle 0.000",
        "running 0.000",
        "running 1.000",
    ]
    assert states(control, [14.0], start_delay=99.0) == ["running 2.000"]


def test_the_start_delay_counts_while_enabled_only():
    control = RunControl()
    states(control, [10.0], start_delay=2.0)
    control.enable(11.0, False)
    assert states(control, [15.0, 20.0], start_delay=2.0) == ["idle 0.000", "idle 0.000"]
    control.enable(20.0, True)
    assert states(control, [20.5, 21.5], start_delay=2.0) == ["idle 0.000", "running 0.500"]


def test_it_finishes_at_its_duration():
    control = RunControl()
    assert states(control, [0.0, 4.0, 5.0, 9.0], duration=5.0) == [
        "running 0.000",
        "running 4.000",
        "finished 5.000",
        "finished 5.000",
    ]


def test_duration_before_first_sample_finishes_it():
    control = RunControl()
    assert states(control, [0.0, 4.0], start_delay=2.0, duration=0.5) == [
        "idle 0.000",
        "finished 0.500",
    ]


def test_longer_duration_continues_from_end():
    control = RunControl()
    states(control, [0.0, 6.0, 9.0], duration=5.0)
    assert states(control, [10.0, 11.0]) == ["running 5.000", "running 6.000"]


def test_a_shorter_duration_finishes_it_without_going_back():
    control = RunControl()
    states(control, [0.0, 8.0])
    assert states(control, [8.5, 9.0], duration=5.0) == ["finished 8.000", "finished 8.000"]


def test_enable_does_not_restart_a_finished_signal_but_reset_does():
    control = RunControl()
    states(control, [0.0, 6.0], duration=5.0)
    control.enable(7.0, False)
    control.enable(8.0, True)
    assert states(control, [9.0], duration=5.0) == ["finished 5.000"]
    control.reset()
    assert states(control, [10.0, 12.0], duration=5.0) == ["running 0.000", "running 2.000"]


def test_reset_takes_the_time_back_also_while_stopped():
    control = RunControl()
    states(control, [0.0, 6.0])
    control.reset()
    assert states(control, [7.0, 8.0]) == ["running 0.000", "running 1.000"]
    control.enable(8.0, False)
    control.reset()
    assert states(control, [9.0]) == ["idle 0.000"]
    control.enable(10.0, True)
    assert states(control, [11.0]) == ["running 1.000"]


def test_reset_restarts_pending_delay_and_skips_elapsed_one():
    control = RunControl()
    states(control, [0.0, 1.0], start_delay=2.0)
    control.reset()
    assert states(control, [1.5, 3.0, 3.5], start_delay=2.0) == [
        "idle 0.000",
        "idle 0.000",
        "running 0.000",
    ]
    control.reset()
    assert states(control, [5.0], start_delay=2.0) == ["running 0.000"]


def test_a_clock_set_back_does_not_take_the_time_back():
    control = RunControl()
    states(control, [100.0, 105.0])
    assert states(control, [50.0, 51.0]) == ["running 5.000", "running 6.000"]
    control.enable(20.0, False)
    assert states(control, [15.0, 16.0]) == ["idle 6.000", "idle 6.000"]
    control.enable(10.0, True)
    assert states(control, [10.5]) == ["running 6.500"]


operations = st.one_of(
    st.tuples(st.just("at"), st.floats(-5.0, 20.0), st.floats(0.0, 30.0)),
    st.tuples(st.just("enable"), st.floats(-5.0, 20.0), st.booleans()),
)


@given(st.lists(operations, max_size=40), st.floats(0.0, 10.0))
def test_time_never_runs_backwards_nor_faster_than_the_clock(steps, start_delay):
    control, clock, before, passed = RunControl(), 1000.0, 0.0, 0.0
    for operation, interval, argument in steps:
        clock += interval
        passed += max(0.0, interval)
        if operation == "enable":
            control.enable(clock, argument)
            continue
        status = control.at(clock, start_delay, argument)
        assert before <= status.time_x <= passed + 1e-9
        assert status.state in ("idle", "running", "finished")
        before = status.time_x
