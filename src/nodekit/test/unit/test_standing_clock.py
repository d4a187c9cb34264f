"""Tests of the cost of timers while /clock is paused."""

import time

import rospy
from rosgraph_msgs.msg import Clock

from nodekit.testing.waiting import wait_until
from nodekit.timing import clocks
from nodekit.timing.scheduler import Scheduler, Timer

#: How long to look, s, and how much of it may be spent computing: a busy loop would take all of
#: what the machine gives it, and turn thousands of times.
LOOK_S = 0.5
BUSY_S = 0.1
TURNS = 20


class StandingClock(clocks.SimulatedClock):
    """Counts how often a scheduler waits."""

    waits = 0

    def wait_until(self, moment):
        self.waits += 1
        super().wait_until(moment)


def test_stopped_clock_uses_no_cpu_time(monkeypatch):
    monkeypatch.setattr(clocks.rospy, "Subscriber", lambda *args, **kwds: None)
    clock = StandingClock()
    scheduler = Scheduler(clock)
    calls = []
    try:
        scheduler.start([Timer(scheduler, calls.append, 1000.0) for _ in range(10)])
        for moment in (10.0, 10.0005, 10.0005):
            clock._on_clock(Clock(rospy.Time.from_sec(moment)))
        wait_until(lambda: len(calls) >= 10, lambda: str(calls))
        turns, busy = clock.waits, time.process_time()
        time.sleep(LOOK_S)
        assert clock.waits - turns < TURNS
        assert time.process_time() - busy < BUSY_S
    finally:
        scheduler.close()


def test_missing_clock_is_logged_once(monkeypatch):
    monkeypatch.setattr(clocks.rospy, "Subscriber", lambda *args, **kwds: None)
    monkeypatch.setattr(clocks, "_PATIENCE_S", 0.01)
    told = []
    monkeypatch.setattr(clocks.rospy, "logwarn", told.append)
    scheduler = Scheduler(clocks.SimulatedClock())
    calls = []
    try:
        wait_until(lambda: told, lambda: "nothing was told")
        for _ in range(2):
            scheduler.start([Timer(scheduler, calls.append, 1.0)])
        scheduler._clock._on_clock(Clock(rospy.Time.from_sec(10.0)))
        wait_until(lambda: len(calls) == 2, lambda: str(calls))
    finally:
        scheduler.close()
    assert told == ["waiting for /clock, as /use_sim_time is set"]
