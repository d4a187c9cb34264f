"""Periodic work without drift that can be retimed or stopped at once.

One thread serves all periodic tasks of a process. It waits on absolute
deadlines, so lateness of one call never delays the next, and it is woken when a
rate changes. It follows /clock where /use_sim_time is set: at most one call for
each step of the clock, none while it stands still.
"""

import contextlib
import heapq
import itertools
import threading
import traceback
from typing import Callable, Iterator, List, Optional, Tuple, Union

import rospy

from nodekit.timing.clocks import MonotonicClock, SimulatedClock
from nodekit.timing.timetable import SLACK_S, Timetable

AnyClock = Union[MonotonicClock, SimulatedClock]
Callback = Callable[[float], None]


class PeriodicTask:
    """A function that is called at a rate; made by :meth:`Scheduler.every`."""

    def __init__(self, scheduler: "Scheduler", callback: Callback, catch_up: float) -> None:
        self.callback = callback
        self.catch_up = catch_up
        self.timetable: Optional[Timetable] = None
        self.paused = False
        #: Counts how often it was planned; what was queued before is void.
        self.generation = 0
        self._scheduler = scheduler

    def set_rate(self, rate: float) -> None:
        """Change the rate with immediate effect.

        :param rate: calls a second, Hz; 0 pauses
        """
        self._scheduler.set_rate(self, rate)


class Scheduler:
    """Calls periodic tasks from one thread of its own.

    :param clock: the time to go by; that of rospy where None
    """

    def __init__(self, clock: Optional[AnyClock] = None) -> None:
        if clock is None:
            clock = MonotonicClock() if rospy.rostime.is_wallclock() else SimulatedClock()
        self._clock = clock
        self._lock = threading.Lock()
        self._tasks: List[PeriodicTask] = []
        self._unplanned: List[PeriodicTask] = []
        self._held = 0
        #: (deadline, tie-break, generation, task) of what is planned, a heap.
        self._queue: List[Tuple[float, int, int, PeriodicTask]] = []
        self._order = itertools.count()
        self._latest = float("-inf")
        self._closed = False
        rospy.on_shutdown(self.close)
        threading.Thread(target=self._run, name="scheduler", daemon=True).start()

    def every(self, rate: float, callback: Callback, catch_up: float = 0.0) -> PeriodicTask:
        """Call a function at a rate, the first time at once.

        :param rate: calls a second, Hz; 0 pauses
        :param callback: called with the time since the first call, s; short,
            since the other tasks of the process wait for it
        :param catch_up: lateness up to which calls are made up for, s; never
            where time is simulated
        :returns: the task, to change its rate by
        """
        if not isinstance(self._clock, MonotonicClock):
            catch_up = 0.0
        task = PeriodicTask(self, callback, catch_up)
        with self._lock:
            self._tasks.append(task)
        self.set_rate(task, rate)
        return task

    @contextlib.contextmanager
    def starting_together(self) -> Iterator[None]:
        """Let the tasks that are made meanwhile begin together, once all of them are there.

        Those of one rate are then due at the same moments for good. Called one after the other,
        they need about half the processor time, as each finds the caches warm.
        """
        with self._lock:
            self._held += 1
        try:
            yield
        finally:
            with self._lock:
                self._held -= 1
            self._clock.wake()

    def set_rate(self, task: PeriodicTask, rate: float) -> None:
        """Change a task's rate; see :meth:`PeriodicTask.set_rate`."""
        with self._lock:
            task.paused = rate <= 0.0
            if task.timetable is not None and not task.paused:
                task.timetable.set_rate(rate)
            elif not task.paused:
                task.timetable = Timetable(rate, task.catch_up)
            self._unplanned.append(task)
        self._clock.wake()

    def close(self) -> None:
        """Call nothing any more."""
        self._closed = True
        self._clock.wake()

    def _run(self) -> None:
        while not self._closed:
            now = self._clock.now()
            if now is not None:
                for callback, elapsed in self._take_due(now):
                    if self._closed:
                        return
                    try:
                        callback(elapsed)
                    except Exception:  # one task's defect must not end the others
                        rospy.logerr_throttle(
                            5.0, "a periodic task failed:\n%s" % traceback.format_exc()
                        )
            self._clock.wait_until(self._queue[0][0] if self._queue else None)

    def _take_due(self, now: float) -> List[Tuple[Callback, float]]:
        """Return what is to be called now, and queue it for the next time."""
        due: List[Tuple[Callback, float]] = []
        with self._lock:
            if now < self._latest:
                self._follow_clock_back(now)
            self._latest = now
            if self._unplanned and not self._held:
                for task in self._unplanned:
                    self._plan(task, now)
                self._unplanned = []
            queue = self._queue
            while queue and queue[0][0] <= now + SLACK_S:
                _, order, generation, task = queue[0]
                if generation != task.generation or task.timetable is None:
                    heapq.heappop(queue)
                    continue
                due.append((task.callback, task.timetable.take(now)))
                deadline = task.timetable.deadline(now)
                heapq.heapreplace(queue, (deadline, order, generation, task))
        return due

    def _plan(self, task: PeriodicTask, now: float) -> None:
        task.generation += 1
        if task.timetable is not None and not task.paused:
            deadline = task.timetable.deadline(now)
            heapq.heappush(self._queue, (deadline, next(self._order), task.generation, task))

    def _follow_clock_back(self, now: float) -> None:
        self._queue = []
        self._unplanned = list(self._tasks)
        for task in self._tasks:
            if task.timetable is not None:
                task.timetable.restart(now)


_scheduler: Optional[Scheduler] = None
_scheduler_lock = threading.Lock()


def get_scheduler() -> Scheduler:
    """Return this process's scheduler, made at the first call.

    :returns: a scheduler on the clock of rospy; the node must have been initialised
    """
    global _scheduler
    with _scheduler_lock:
        if _scheduler is None:
            _scheduler = Scheduler()
        return _scheduler
