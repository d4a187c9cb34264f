"""Timers without drift, with rates that can change immediately.

One thread serves all timers of a clock. It waits on absolute deadlines, so that a late call never
delays the next, and is woken when a rate changes. With /use_sim_time it follows /clock: at most one
call for each step of the clock, and no call while the clock stands still.
"""

import heapq
import itertools
import math
import numbers
import threading
import traceback
from typing import Callable, Iterable, List, Optional, Set, Tuple, Union

import rospy

from nodekit.process_context import PROCESS
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
from nodekit.throttle import Throttle
from nodekit.timing.clocks import MonotonicClock, SimulatedClock
from nodekit.timing.timetable import SLACK_S, Timetable

AnyClock = Union[MonotonicClock, SimulatedClock]
Callback = Callable[[float], None]
Work = Callable[[], None]
Dispatch = Callable[[Work], None]

#: Highest rate of a timer [Hz]: deadlines must be further apart than SLACK_S.
HIGHEST_HZ = 0.1 / SLACK_S
#: Shortest time between two log lines about exceptions of one timer [s].
_LOG_PERIOD_S = 5.0


def checked_rate(rate: float) -> float:
    """Return a rate that a timer can keep.

    :param rate: rate of the calls [Hz]; 0 pauses
    :raises ValueError: if the rate is not a number, below 0, or above :data:`HIGHEST_HZ`
    """
    if isinstance(rate, numbers.Real) and 0.0 <= rate <= HIGHEST_HZ:
        return float(rate)
    raise ValueError(f"a rate of {rate!r} Hz: must be a number in [0, {HIGHEST_HZ:g}]")


def _call_now(work: Work) -> None:
    work()


class Timer:
    """Timer that calls a function at a rate.

    :param scheduler: the scheduler; :meth:`Scheduler.start` starts the timer
    :param callback: called with the time since the first call [s]; must be short, since all other
        timers wait for it
    :param rate: rate of the calls [Hz]; 0 pauses
    :param catch_up: lateness up to which missed calls are made [s]; ignored in simulated time
    :param dispatch: calls a function now or later; now by default
    :raises ValueError: if the rate is invalid
    """

    def __init__(
        self,
        scheduler: "Scheduler",
        callback: Callback,
        rate: float,
        catch_up: float = 0.0,
        dispatch: Optional[Dispatch] = None,
    ) -> None:
        self._scheduler = scheduler
        self._callback = callback
        catch_up = scheduler.allowed_catch_up(catch_up)
        self._catches_up = catch_up > 0.0
        #: Calls a function, now or later.
        self.dispatch: Dispatch = dispatch or _call_now
        self.timetable = Timetable(checked_rate(rate), catch_up)
        #: Pending calls, by the time since the first call [s].
        self._due: List[float] = []
        self._skipped = 0
        self._throttle = Throttle(_LOG_PERIOD_S)

    @property
    def skipped(self) -> int:
        """Number of skipped calls, which would have been too late."""
        return self._skipped + self.timetable.skipped

    def set_rate(self, rate: float) -> None:
        """Change the rate with immediate effect.

        :param rate: rate of the calls [Hz]; 0 pauses
        :raises ValueError: if the rate is invalid; the old one stays
        """
        self._scheduler.set_rate(self, checked_rate(rate))
        if rate == 0.0:
            self._due.clear()

    def close(self) -> None:
        """Stop the calls."""
        self._scheduler.remove(self)
        self._due.clear()

    def add_call(self, elapsed: float) -> bool:
        """Add a call that is due, or skip it while another one is pending.

        :param elapsed: time since the first call [s]
        :returns: whether to dispatch the call
        """
        is_call = self._catches_up or not self._due
        if is_call:
            self._due.append(elapsed)
        else:
            self._skipped += 1
        return is_call

    def forget_one(self) -> None:
        """Remove a dispatched call that will not be made."""
        del self._due[:1]

    def tick(self) -> None:
        """Make one pending call; calls are dispatched one by one."""
        try:
            elapsed = self._due.pop(0)
        except IndexError:
            return  # the timer was just closed or paused
        try:
            self._callback(elapsed)
        except BaseException:  # must not end the other timers
            if self._throttle.is_due():
                rospy.logerr("a timer failed:\n%s", traceback.format_exc())


class Scheduler:
    """Scheduler of timers, with one thread.

    :param clock: the clock of all its timers
    """

    def __init__(self, clock: AnyClock) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._timers: Set[Timer] = set()
        #: Heap of (deadline, tie-break, timer) of timers that are not paused.
        self._queue: List[Tuple[float, int, Timer]] = []
        self._order = itertools.count()
        self._latest = -math.inf
        self._closed = False
        at_end(ShutdownPhase.TOOLKIT, self.close)
        threading.Thread(target=self._run, name="scheduler", daemon=True).start()

    def allowed_catch_up(self, catch_up: float) -> float:
        """Return the catch-up time on this clock: 0 in simulated time, which may jump.

        :param catch_up: requested lateness up to which missed calls are made [s]
        """
        return catch_up if isinstance(self._clock, MonotonicClock) else 0.0

    def start(self, timers: Iterable[Timer]) -> None:
        """Start timers; the first call is due immediately.

        Timers of one rate stay due at the same moments. Called one after the other, they need about
        half the processor time, because of warm caches.

        :param timers: new ones
        """
        with self._lock:
            for timer in timers:
                self._timers.add(timer)
                self._plan(timer)
        self._clock.wake()

    def set_rate(self, timer: Timer, rate: float) -> None:
        """Change a timer's rate; see :meth:`Timer.set_rate`."""
        with self._lock:
            timer.timetable.set_rate(rate)
            if timer in self._timers:
                self._unqueue(timer)
                self._plan(timer)
        self._clock.wake()

    def remove(self, timer: Timer) -> None:
        """Remove a timer; see :meth:`Timer.close`."""
        with self._lock:
            self._timers.discard(timer)
            self._unqueue(timer)

    def close(self) -> None:
        """Stop all timers."""
        self._closed = True
        self._clock.wake()

    def _plan(self, timer: Timer) -> None:
        """Queue a timer for its next deadline; a new timer is due immediately."""
        deadline = timer.timetable.deadline
        if deadline is not None:
            heapq.heappush(self._queue, (deadline, next(self._order), timer))

    def _unqueue(self, timer: Timer) -> None:
        queue = [entry for entry in self._queue if entry[2] is not timer]
        if len(queue) < len(self._queue):
            self._queue = queue
            heapq.heapify(queue)

    def _run(self) -> None:
        while not self._closed:
            now, moment = self._clock.now(), None
            if now is not None:
                due, moment = self._take_due(now)
                for timer in due:
                    if self._closed:
                        return
                    timer.dispatch(timer.tick)
            # Setting an earlier deadline also wakes the clock.
            self._clock.wait_until(moment)

    def _take_due(self, now: float) -> Tuple[List[Timer], Optional[float]]:
        """Return the timers to dispatch now, and the next deadline.

        Each timer is queued again for its next deadline.
        """
        found: List[Timer] = []
        with self._lock:
            if now < self._latest:
                self._follow_clock_back(now)
            self._latest = now
            queue = self._queue
            while queue and queue[0][0] <= now + SLACK_S:
                _, order, timer = queue[0]
                timetable = timer.timetable
                if timer.add_call(timetable.take_deadline(now)):
                    found.append(timer)
                heapq.heapreplace(queue, (timetable.next_deadline, order, timer))
            return found, queue[0][0] if queue else None

    def _follow_clock_back(self, now: float) -> None:
        self._queue = []
        for timer in self._timers:
            timer.timetable.restart(now)
            self._plan(timer)


def get_scheduler(steady: bool = False) -> Scheduler:
    """Return one of this process's schedulers, created at the first call.

    :param steady: whether to use the monotonic clock also in simulated time, as for time-outs
    :returns: the scheduler; requires an initialised node
    """
    if steady or rospy.rostime.is_wallclock():
        return PROCESS.get(Scheduler, lambda: Scheduler(MonotonicClock()), "monotonic")
    return PROCESS.get(Scheduler, lambda: Scheduler(SimulatedClock()), "simulated")
