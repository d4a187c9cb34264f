#!/usr/bin/env python3
"""Periodic work on a simulated clock that stands still, jumps or is set back, and on the machine's.

The test itself publishes /clock, so that nothing here depends on time passing.
"""

import unittest
from typing import List

import rospy
import rostest
from rosgraph_msgs.msg import Clock

from nodekit.testing.waiting import wait_until
from nodekit.timing.clocks import MonotonicClock
from nodekit.timing.scheduler import PeriodicTask, Scheduler

QUARTER_OF_AN_HOUR = 0.001  # Hz


class OnClock(unittest.TestCase):
    """Tasks of a scheduler that keep what they are called with."""

    def setUp(self) -> None:
        self.calls: List[float] = []
        self.steps = 0

    def schedule(self, scheduler: Scheduler, rate: float) -> PeriodicTask:
        self.addCleanup(scheduler.close)
        return scheduler.every(rate, self.calls.append)

    def assert_calls(self, *elapsed: float) -> None:
        """Wait until there are as many calls; compare what they were called with."""
        wait_until(lambda: len(self.calls) >= len(elapsed), lambda: str(self.calls))
        self.assertEqual([round(call, 6) for call in self.calls], list(elapsed))


class OnSimulatedClock(OnClock):
    """The scheduler's own choice of clock where /use_sim_time is set."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        wait_until(lambda: cls.clock.get_num_connections() > 0, lambda: "/clock is not heard")

    def start(self, rate: float) -> PeriodicTask:
        """Start a task, and one that is due at every step, which shows that the step was seen."""
        scheduler = Scheduler()
        task = self.schedule(scheduler, rate)
        scheduler.every(100000.0, self.count_step)
        return task

    def count_step(self, _elapsed: float) -> None:
        self.steps += 1

    def step(self, *times: float) -> None:
        """Set the clock, and wait until each time is seen."""
        for time in times:
            before = self.steps
            self.clock.publish(Clock(rospy.Time.from_sec(time)))
            wait_until(lambda: self.steps > before, lambda: "%g s is not seen" % time)

    def test_nothing_is_due_before_the_clock_runs(self) -> None:
        task = self.start(10.0)
        task.set_rate(20.0)
        self.step(5.0, 5.05)
        self.assert_calls(0.0, 0.05)

    def test_clock_that_stands_still(self) -> None:
        task = self.start(2.0)
        self.step(10.0)
        for rate in (100.0, 1000.0, 0.0, 1000.0, 20.0):
            task.set_rate(rate)
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

    def test_clock_that_jumps_ahead_skips_what_was_due(self) -> None:
        self.start(10.0)
        self.step(30.0, 37.25, 37.28, 37.3)
        self.assert_calls(0.0, 7.2, 7.3)

    def test_clock_that_is_set_back(self) -> None:
        self.start(10.0)
        self.step(100.0, 100.1, 50.0, 50.05, 50.1, 2.0, 2.1)
        self.assert_calls(0.0, 0.1, 0.2, 0.3, 0.4, 0.5)

    def test_tasks_that_start_together_stay_together(self) -> None:
        scheduler = Scheduler()
        scheduler.every(100000.0, self.count_step)
        self.step(10.0)
        with scheduler.starting_together():
            self.schedule(scheduler, 10.0)
            self.step(10.02)
            self.schedule(scheduler, 10.0)
            self.step(10.04)
            self.assertEqual(self.calls, [])
        self.assert_calls(0.0, 0.0)
        self.step(10.13, 10.14)
        self.assert_calls(0.0, 0.0, 0.1, 0.1)

    def test_slow_task_becomes_quick_without_a_step(self) -> None:
        task = self.start(QUARTER_OF_AN_HOUR)
        self.step(10.0, 13.0)
        task.set_rate(QUARTER_OF_AN_HOUR / 2)
        task.set_rate(50.0)
        self.assert_calls(0.0, 3.0)
        self.step(13.02)
        self.assert_calls(0.0, 3.0, 3.02)

    def test_rate_that_is_set_many_times_is_kept_once(self) -> None:
        task = self.start(10.0)
        for _ in range(5):
            task.set_rate(10.0)
        self.step(*(60.0 + number / 40 for number in range(10)))
        self.assert_calls(0.0, 0.1, 0.2)

    def test_pause_counts_as_time(self) -> None:
        task = self.start(10.0)
        self.step(70.0, 70.1)
        task.set_rate(0.0)
        self.step(70.2, 70.3, 75.0)
        task.set_rate(10.0)
        self.assert_calls(0.0, 0.1, 5.0)
        self.step(75.1)
        self.assert_calls(0.0, 0.1, 5.0, 5.1)

    def test_task_that_fails_harms_no_other(self) -> None:
        scheduler = Scheduler()
        scheduler.every(100000.0, self.fail_at_step)
        self.schedule(scheduler, 10.0)
        self.step(80.0, 80.1)
        self.assert_calls(0.0, 0.1)

    def fail_at_step(self, elapsed: float) -> None:
        self.count_step(elapsed)
        raise ZeroDivisionError


class OnMachinesClock(OnClock):
    """The machine's clock can be waited for only; so each test ends as soon as it may."""

    def test_slow_task_becomes_quick_at_once(self) -> None:
        task = self.schedule(Scheduler(MonotonicClock()), QUARTER_OF_AN_HOUR)
        wait_until(lambda: self.calls, lambda: "no first call")
        task.set_rate(1000.0)
        wait_until(lambda: len(self.calls) > 50, lambda: str(self.calls))
        self.assertEqual(self.calls, sorted(self.calls))

    def test_calls_are_spaced_by_the_rate(self) -> None:
        self.schedule(Scheduler(MonotonicClock()), 200.0)
        wait_until(lambda: len(self.calls) > 20, lambda: str(self.calls))
        for call in self.calls:
            self.assertAlmostEqual(call * 200.0, round(call * 200.0), 6)

    def test_closed_scheduler_calls_nothing(self) -> None:
        scheduler = Scheduler(MonotonicClock())
        task = self.schedule(scheduler, QUARTER_OF_AN_HOUR)
        wait_until(lambda: self.calls, lambda: "no first call")
        scheduler.close()
        task.set_rate(1000.0)
        other = Scheduler(MonotonicClock())
        self.addCleanup(other.close)
        ticks: List[float] = []
        other.every(1000.0, ticks.append)
        wait_until(lambda: len(ticks) > 50, lambda: str(ticks))
        self.assertEqual(len(self.calls), 1)


if __name__ == "__main__":
    rospy.init_node("test_scheduling")
    rostest.rosrun("nodekit", "scheduling", "test_scheduling")
