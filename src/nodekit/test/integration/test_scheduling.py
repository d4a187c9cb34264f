#!/usr/bin/env python3
"""Tests of timers with a simulated clock that pauses or jumps, and with the machine's.

The test itself publishes /clock, so that nothing here depends on time passing.
"""

import functools
import gc
import math
import time
import unittest
import weakref
from typing import Any, Callable, List, Optional, Tuple, Type

import rospy
from rosgraph_msgs.msg import Clock

from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from nodekit.timing.clocks import MonotonicClock, SimulatedClock
from nodekit.timing.scheduler import (
    HIGHEST_HZ,
    AnyClock,
    Scheduler,
    Timer,
    checked_rate,
    get_scheduler,
)

QUARTER_OF_AN_HOUR = 0.001  # Hz
EVERY_STEP = 100000.0  # Hz


class RoundsClock(SimulatedClock):
    """Tells each time that a scheduler has rung all timers that were due.

    :param on_round: what to call then
    """

    def __init__(self, on_round: Callable[[], None]) -> None:
        self._on_round = on_round
        super().__init__()

    def wait_until(self, moment: Optional[float]) -> None:
        self._on_round()
        super().wait_until(moment)


class OnClock(unittest.TestCase):
    """Timers of a scheduler that record their arguments."""

    def setUp(self) -> None:
        self.calls: List[float] = []
        self.steps = 0
        self.is_synchronized = False

    def scheduler(self, clock: AnyClock) -> Scheduler:
        scheduler = Scheduler(clock)
        self.addCleanup(scheduler.close)
        return scheduler

    def timer(
        self, scheduler: Scheduler, rate: float, catch_up: float = 0.0, dispatch: Any = None
    ) -> Timer:
        """Return a timer that records its arguments, not started."""
        return Timer(scheduler, self.calls.append, rate, catch_up, dispatch)

    def assert_calls(self, *elapsed: float) -> None:
        """Wait for the number of calls, and compare their arguments."""
        wait_until(lambda: len(self.calls) >= len(elapsed), lambda: str(self.calls))
        self.assertEqual([round(call, 6) for call in self.calls], list(elapsed))


class OnSimulatedClock(OnClock):
    """Scheduling with /use_sim_time."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        wait_until(lambda: cls.clock.get_num_connections() > 0, lambda: "/clock is not heard")

    def start(self, rate: float, catch_up: float = 0.0, dispatch: Any = None) -> Timer:
        """Start a timer, and another one due at every step, to see that the step was processed."""
        scheduler = self.scheduler(RoundsClock(self.end_round))
        timer = self.timer(scheduler, rate, catch_up, dispatch)
        scheduler.start([timer, Timer(scheduler, self.count_step, EVERY_STEP)])
        return timer

    def count_step(self, _elapsed: float) -> None:
        self.is_synchronized = True

    def end_round(self) -> None:
        if self.is_synchronized:
            self.is_synchronized = False
            self.steps += 1

    def step(self, *times: float) -> None:
        """Set the clock step by step, and wait until all due calls are made."""
        for time_s in times:
            before = self.steps
            self.clock.publish(Clock(rospy.Time.from_sec(time_s)))
            wait_until(lambda: self.steps > before, lambda: f"{time_s:g} s is not seen")

    def test_nothing_is_due_before_the_clock_runs(self) -> None:
        timer = self.start(10.0)
        timer.set_rate(20.0)
        self.step(5.0, 5.05)
        self.assert_calls(0.0, 0.05)

    def test_clock_that_does_not_advance(self) -> None:
        timer = self.start(2.0)
        self.step(10.0)
        for rate in (100.0, 1000.0, 0.0, 1000.0, 20.0):
            timer.set_rate(rate)
        self.clock.publish(Clock(rospy.Time.from_sec(10.0)))
        self.step(10.05, 10.06, 10.1)
        self.assert_calls(0.0, 0.05, 0.1)

    def test_rate_above_the_clocks_means_one_call_a_step(self) -> None:
        self.start(1000.0)
        self.step(*(20.0 + number / 10 for number in range(5)))
        self.assert_calls(0.0, 0.1, 0.2, 0.3, 0.4)

    def test_rate_of_the_clock_itself_means_a_call_at_every_step(self) -> None:
        self.start(10.0)
        start = 1700000000.3  # rounded to 2.4e-7 s
        self.step(*(start + number / 10 for number in range(20)))
        self.assert_calls(*(number / 10 for number in range(20)))

    def test_clock_jump_ahead_skips_missed_deadlines(self) -> None:
        timer = self.start(10.0)
        self.step(30.0, 37.25, 37.28, 37.3)
        self.assert_calls(0.0, 7.2, 7.3)
        self.assertEqual(timer.skipped, 71)

    def test_simulated_time_is_never_caught_up_with(self) -> None:
        timer = self.start(10.0, catch_up=100.0)
        self.step(30.0, 32.25, 32.28, 32.3)
        self.assert_calls(0.0, 2.2, 2.3)
        self.assertEqual(timer.skipped, 21)

    def test_clock_that_is_set_back(self) -> None:
        self.start(10.0)
        self.step(100.0, 100.1, 50.0, 50.05, 50.1, 2.0, 2.1)
        self.step(1.95, 2.0, 2.05)  # by less than two periods
        self.assert_calls(0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)

    def test_timers_that_start_together_stay_together(self) -> None:
        scheduler = self.scheduler(RoundsClock(self.end_round))
        scheduler.start([Timer(scheduler, self.count_step, EVERY_STEP)])
        self.step(10.0)
        first = self.timer(scheduler, 10.0)
        self.step(10.02)
        second = self.timer(scheduler, 10.0)
        self.step(10.04)
        self.assertEqual(self.calls, [])
        scheduler.start([first, second])
        self.assert_calls(0.0, 0.0)
        self.step(10.13, 10.14)
        self.assert_calls(0.0, 0.0, 0.1, 0.1)
        self.step(10.77, 10.83, 10.84)
        self.assert_calls(0.0, 0.0, 0.1, 0.1, 0.7, 0.7, 0.8, 0.8)
        self.assertEqual((first.skipped, second.skipped), (5, 5))
        for timer in (first, second):
            timer.set_rate(20.0)
        self.step(10.88, 10.89)
        self.assert_calls(0.0, 0.0, 0.1, 0.1, 0.7, 0.7, 0.8, 0.8, 0.85, 0.85)
        self.step(5.0, 5.04, 5.05)
        self.assertEqual(
            [round(call, 6) for call in self.calls[-4:]], [0.9, 0.9, 0.95, 0.95], self.calls
        )

    def test_timers_that_start_one_after_the_other_keep_apart(self) -> None:
        scheduler = self.scheduler(RoundsClock(self.end_round))
        scheduler.start(
            [self.timer(scheduler, 10.0), Timer(scheduler, self.count_step, EVERY_STEP)]
        )
        self.step(10.0, 10.04)
        scheduler.start([self.timer(scheduler, 10.0)])
        self.assert_calls(0.0, 0.0)
        self.step(10.1)
        self.assert_calls(0.0, 0.0, 0.1)
        self.step(10.14)
        self.assert_calls(0.0, 0.0, 0.1, 0.1)

    def keep(self, rate: float) -> Tuple[Timer, List[Callable[[], None]]]:
        """Start a timer with queued calls, as in a busy group."""
        kept: List[Callable[[], None]] = []
        timer = self.start(rate, dispatch=kept.append)
        return timer, kept

    def test_kept_call_skips_deadlines_until_it_is_made(self) -> None:
        timer, kept = self.keep(10.0)
        self.step(9.0, 9.1, 9.2)
        self.assertEqual(len(kept), 1, "it is not dispatched again before it is made")
        self.assertEqual((self.calls, timer.skipped), ([], 2))
        kept[0]()
        kept[0]()
        self.assert_calls(0.0)
        self.step(9.3)
        wait_until(lambda: len(kept) == 2, lambda: str(kept))
        kept[1]()
        self.assert_calls(0.0, 0.3)
        self.assertEqual(timer.skipped, 2)

    def test_call_that_is_kept_over_a_change_of_the_rate(self) -> None:
        timer, kept = self.keep(10.0)
        self.step(9.0)
        timer.set_rate(0.5)
        kept[0]()
        self.assert_calls(0.0)
        self.step(10.9)
        self.assertEqual(len(kept), 1)
        self.step(11.0)
        wait_until(lambda: len(kept) == 2, lambda: str(kept))
        kept[1]()
        self.assert_calls(0.0, 2.0)

    def test_kept_call_is_not_made_after_the_timer_is_paused_or_closed(self) -> None:
        for end in (lambda timer: timer.set_rate(0.0), Timer.close):
            timer, kept = self.keep(10.0)
            self.step(9.0)
            end(timer)
            kept[0]()
            self.assertEqual(self.calls, [])
            timer._scheduler.close()

    def test_closed_timer_is_called_no_more_while_others_are(self) -> None:
        timer = self.start(10.0)
        self.step(9.0, 9.1)
        timer.close()
        self.step(9.2, 9.3)
        for rate in (1000.0, 0.0, 10.0):
            timer.set_rate(rate)
        self.step(9.4, 5.0, 5.1)
        timer.close()
        self.assert_calls(0.0, 0.1)

    def test_timer_that_closes_itself_or_another_in_its_call(self) -> None:
        scheduler = self.scheduler(RoundsClock(self.end_round))
        timers: List[Timer] = []

        def end_both(elapsed: float) -> None:
            self.calls.append(elapsed)
            for timer in timers:
                timer.close()

        timers += [Timer(scheduler, end_both, 10.0) for _ in range(2)]
        scheduler.start([*timers, Timer(scheduler, self.count_step, EVERY_STEP)])
        self.step(9.0, 9.1, 9.2)
        self.assert_calls(0.0)

    def test_the_process_scheduler_follows_clock_unless_it_is_to_be_steady(self) -> None:
        self.assertIs(get_scheduler(), get_scheduler())
        self.assertIs(get_scheduler(steady=True), get_scheduler(steady=True))
        followed, steady = self.timer(get_scheduler(), 10.0), []
        by_machine = Timer(get_scheduler(steady=True), steady.append, 1000.0)
        for timer in (followed, by_machine):
            self.addCleanup(timer.close)
        get_scheduler(steady=True).start([by_machine])
        get_scheduler().start([followed])
        wait_until(lambda: len(steady) > 20, lambda: str(steady))
        self.assertEqual(self.calls, [])
        self.clock.publish(Clock(rospy.Time.from_sec(30.0)))
        self.assert_calls(0.0)
        self.clock.publish(Clock(rospy.Time.from_sec(30.1)))
        self.assert_calls(0.0, 0.1)

    def test_slow_timer_becomes_quick_without_a_step(self) -> None:
        timer = self.start(QUARTER_OF_AN_HOUR)
        self.step(10.0, 13.0)
        timer.set_rate(QUARTER_OF_AN_HOUR / 2)
        timer.set_rate(50.0)
        self.assert_calls(0.0, 3.0)
        self.step(13.02)
        self.assert_calls(0.0, 3.0, 3.02)

    def test_rate_that_is_set_many_times_is_kept_once(self) -> None:
        timer = self.start(10.0)
        for _ in range(5):
            timer.set_rate(10.0)
        self.step(*(60.0 + number / 40 for number in range(10)))
        self.assert_calls(0.0, 0.1, 0.2)

    def test_pause_counts_as_time(self) -> None:
        timer = self.start(10.0)
        self.step(70.0, 70.1)
        timer.set_rate(0.0)
        self.step(70.2, 70.3, 75.0)
        timer.set_rate(10.0)
        self.assert_calls(0.0, 0.1, 5.0)
        self.step(75.1)
        self.assert_calls(0.0, 0.1, 5.0, 5.1)

    def test_timer_that_fails_harms_no_other(self) -> None:
        for error in (ZeroDivisionError, SystemExit):
            self.calls = []
            scheduler = self.scheduler(RoundsClock(self.end_round))
            failing = Timer(scheduler, functools.partial(self.fail_at_step, error), EVERY_STEP)
            scheduler.start([failing, self.timer(scheduler, 10.0)])
            self.step(80.0, 80.1)
            self.assert_calls(0.0, 0.1)
            scheduler.close()

    def fail_at_step(self, error: Type[BaseException], elapsed: float) -> None:
        self.count_step(elapsed)
        raise error


class OnMachinesClock(OnClock):
    """Tests with the machine's clock, which end as soon as possible."""

    def start(self, rate: float, catch_up: float = 0.0, dispatch: Any = None) -> Timer:
        scheduler = self.scheduler(MonotonicClock())
        timer = self.timer(scheduler, rate, catch_up, dispatch)
        scheduler.start([timer])
        return timer

    def test_calls_to_catch_up_with_are_kept_one_and_all(self) -> None:
        kept: List[Callable[[], None]] = []
        timer = self.start(500.0, catch_up=10.0, dispatch=kept.append)
        wait_until(lambda: kept, lambda: "not dispatched")
        wait_until(lambda: len(timer._due) > 20, lambda: str(timer._due))
        kept[0]()
        self.assertEqual(len(self.calls), 1)  # one turn, one call: others may come in between
        for turn in kept[1:21]:
            turn()
        self.assertEqual(len(self.calls), 21)
        steps = {round(500.0 * (b - a), 6) for a, b in zip(self.calls, self.calls[1:])}
        self.assertEqual((steps, timer.skipped), ({1.0}, 0))

    def test_slow_timer_becomes_quick_immediately(self) -> None:
        timer = self.start(QUARTER_OF_AN_HOUR)
        wait_until(lambda: self.calls, lambda: "no first call")
        timer.set_rate(1000.0)
        wait_until(lambda: len(self.calls) > 50, lambda: str(self.calls))
        self.assertEqual(self.calls, sorted(self.calls))

    def test_calls_are_spaced_by_the_rate(self) -> None:
        self.start(200.0)
        wait_until(lambda: len(self.calls) > 20, lambda: str(self.calls))
        for call in self.calls:
            self.assertAlmostEqual(call * 200.0, round(call * 200.0), 6)

    def test_lateness_is_caught_up_with_as_far_as_allowed(self) -> None:
        for catch_up in (1000.0, 0.0):
            self.calls = []
            timer = self.start(200.0, catch_up)
            wait_until(lambda: self.calls, lambda: "no first call")
            blocker = Timer(timer._scheduler, lambda _elapsed: time.sleep(0.1), QUARTER_OF_AN_HOUR)
            timer._scheduler.start([blocker])
            wait_until(lambda: len(self.calls) > 60, lambda: str(self.calls))
            timer.close()
            numbers = [round(call * 200.0) for call in self.calls]
            if catch_up:
                self.assertEqual(numbers, list(range(len(numbers))))
                self.assertEqual(timer.skipped, 0)
            else:
                self.assertEqual(numbers, sorted(set(numbers)))
                self.assertGreater(timer.skipped, 10)
                self.assertGreaterEqual(timer.skipped, numbers[-1] + 1 - len(numbers))

    def test_closed_scheduler_calls_nothing(self) -> None:
        timer = self.start(QUARTER_OF_AN_HOUR)
        wait_until(lambda: self.calls, lambda: "no first call")
        timer._scheduler.close()
        timer.set_rate(1000.0)
        other = self.scheduler(MonotonicClock())
        ticks: List[float] = []
        other.start([Timer(other, ticks.append, 1000.0)])
        wait_until(lambda: len(ticks) > 50, lambda: str(ticks))
        self.assertEqual(len(self.calls), 1)

    def test_closed_timers_leak_nothing(self) -> None:
        scheduler = self.scheduler(MonotonicClock())
        ticks: List[float] = []
        kept = Timer(scheduler, ticks.append, 1000.0)
        scheduler.start([kept])
        gone = []
        for rate in (QUARTER_OF_AN_HOUR, 500.0, 0.0):
            timers = [self.timer(scheduler, rate) for _ in range(50)]
            scheduler.start(timers)
            for timer in timers:
                for latest in (QUARTER_OF_AN_HOUR, 0.0, QUARTER_OF_AN_HOUR, rate):
                    timer.set_rate(latest)
            self.assertLessEqual(len(scheduler._queue), 51, "each is queued once")
            for timer in timers:
                timer.close()
                timer.set_rate(10.0)
                gone.append(weakref.ref(timer))
            self.assertLessEqual({entry[2] for entry in scheduler._queue}, {kept})
        self.assertEqual(list(scheduler._timers), [kept])
        del timer, timers
        count = len(ticks)  # the thread may be at one of them
        wait_until(lambda: len(ticks) > count + 1, lambda: str(ticks))
        gc.collect()
        self.assertEqual([timer for timer in gone if timer() is not None], [])

    def test_impossible_rates_are_refused_and_stop_no_timer(self) -> None:
        timer = self.start(500.0)
        for rate in (math.inf, -math.inf, math.nan, -1.0, -1e-9, 1.01 * HIGHEST_HZ):
            with self.assertRaises(ValueError, msg=str(rate)) as refused:
                checked_rate(rate)
            self.assertIn(repr(rate), str(refused.exception))
            with self.assertRaises(ValueError, msg=str(rate)):
                self.timer(timer._scheduler, rate)
            with self.assertRaises(ValueError, msg=str(rate)):
                timer.set_rate(rate)
        count = len(self.calls)
        wait_until(lambda: len(self.calls) > count + 20, lambda: str(self.calls))
        for call in self.calls:
            self.assertAlmostEqual(call * 500.0, round(call * 500.0), 6)
        self.assertEqual(
            [checked_rate(rate) for rate in (0, 3, HIGHEST_HZ)], [0.0, 3.0, HIGHEST_HZ]
        )


if __name__ == "__main__":
    rospy.init_node("test_scheduling")
    rosrun("nodekit", "scheduling", "test_scheduling")
