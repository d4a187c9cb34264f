"""Periodic work without drift that can be retimed or stopped at once.

One thread serves all timers of a clock. It waits on absolute deadlines, so lateness of one call
never delays the next, and it is woken when a rate changes. It follows /clock where /use_sim_time
is set: at most one call for each step of the clock, none while it stands still.
"""

import heapq
import itertools
import math
import numbers
import threading
import traceback
from typing import Callable, Dict, Iterable, List, Optional, Set, Tuple, Union

import rospy

from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
from nodekit.throttle import Throttle
from nodekit.timing.clocks import MonotonicClock, SimulatedClock
from nodekit.timing.timetable import SLACK_S, Timetable

AnyClock = Union[MonotonicClock, SimulatedClock]
Callback = Callable[[float], None]
Work = Callable[[], None]
Dispatch = Callable[[Work], None]

#: Highest rate of a timer, Hz: deadlines must be further apart than they are blurred.
HIGHEST_HZ = 0.1 / SLACK_S
#: Shortest time between two log lines about exceptions of one timer [s].
_LOG_PERIOD_S = 5.0


def checked_rate(rate: float) -> float:
    """Return a rate that a timer can keep.

    :param rate: calls a second, Hz; 0 pauses
    :raises ValueError: if it is no number, below 0, or above :data:`HIGHEST_HZ`
    """
    if isinstance(rate, numbers.Real) and 0.0 <= rate <= HIGHEST_HZ:
        return float(rate)
    raise ValueError(f"a rate of {rate!r} Hz: must be a number in [0, {HIGHEST_HZ:g}]")


def _at_once(work: Work) -> None:
    work()


class Timer:
    """A function that is called at a rate.

    :param scheduler: who says when, from when it is given to :meth:`Scheduler.start`
    :param callback: called with the time since the first call, s; short, since all other timers
        wait for it
    :param rate: calls a second, Hz; 0 pauses
    :param catch_up: lateness up to which calls are made up for, s; never where time is simulated
    :param dispatch: calls the function that it is given, now or later; now by default
    :raises ValueError: if the rate is not one to keep
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
        #: Calls the function that it is given, now or later.
        self.dispatch: Dispatch = dispatch or _at_once
        self.timetable = Timetable(checked_rate(rate), catch_up)
        #: Calls that are due and not made yet, by the time since the first one, s.
        self._due: List[float] = []
        self._left_out = 0
        self._throttle = Throttle(_LOG_PERIOD_S)

    @property
    def skipped(self) -> int:
        """Calls that were left out so far, because they would have come too late."""
        return self._left_out + self.timetable.skipped

    def set_rate(self, rate: float) -> None:
        """Change the rate with immediate effect.

        :param rate: calls a second, Hz; 0 pauses
        :raises ValueError: if it is not one to keep; the old one stays
        """
        self._scheduler.set_rate(self, checked_rate(rate))
        if rate == 0.0:
            self._due.clear()

    def close(self) -> None:
        """Make no call any more."""
        self._scheduler.remove(self)
        self._due.clear()

    def add_call(self, elapsed: float) -> bool:
        """Add a call that is due; one that finds another one still waiting is left out.

        :param elapsed: time since the first call, s
        :returns: whether it is to be dispatched
        """
        is_call = self._catches_up or not self._due
        if is_call:
            self._due.append(elapsed)
        else:
            self._left_out += 1
        return is_call

    def forget_one(self) -> None:
        """Forget a call that was dispatched and will not be made."""
        del self._due[:1]

    def tick(self) -> None:
        """Make one call that is due; each of them was dispatched, and has a turn of its own."""
        try:
            elapsed = self._due.pop(0)
        except IndexError:
            return  # it was closed or paused just now
        try:
            self._callback(elapsed)
        except BaseException:  # one timer's defect must not end the others
            if self._throttle.is_due():
                rospy.logerr("a timer failed:\n%s", traceback.format_exc())


class Scheduler:
    """Has the calls of timers made when they are due, from one thread of its own.

    :param clock: the time to go by
    """

    def __init__(self, clock: AnyClock) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._timers: Set[Timer] = set()
        #: (deadline, tie-break, timer) of each that is not paused, a heap.
        self._queue: List[Tuple[float, int, Timer]] = []
        self._order = itertools.count()
        self._latest = -math.inf
        self._closed = False
        at_end(ShutdownPhase.TOOLKIT, self.close)
        threading.Thread(target=self._run, name="scheduler", daemon=True).start()

    def allowed_catch_up(self, catch_up: float) -> float:
        """Return how far a timer may catch up on this clock: simulated time jumps.

        :param catch_up: how far it would, s
        """
        return catch_up if isinstance(self._clock, MonotonicClock) else 0.0

    def start(self, timers: Iterable[Timer]) -> None:
        """Begin to call timers, the first time at once.

        Those of one rate are then due at the same moments for good. Called one after the other,
        they need about half the processor time, as each finds the caches warm.

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
        """Forget a timer; see :meth:`Timer.close`."""
        with self._lock:
            self._timers.discard(timer)
            self._unqueue(timer)

    def close(self) -> None:
        """Call nothing any more."""
        self._closed = True
        self._clock.wake()

    def _plan(self, timer: Timer) -> None:
        """Queue a timer for its next deadline; a new one is due at once."""
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
            # What has put a deadline before this moment since has also waked the clock.
            self._clock.wait_until(moment)

    def _take_due(self, now: float) -> Tuple[List[Timer], Optional[float]]:
        """Return the timers to be dispatched now, and when the next ones are due.

        Each is queued again for its next time.
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


_schedulers: Dict[bool, Scheduler] = {}
_schedulers_lock = threading.Lock()


def get_scheduler(steady: bool = False) -> Scheduler:
    """Return one of this process's schedulers, made at the first call.

    :param steady: whether to go by the machine's monotonic clock in any case, as time-outs do, and
        not by rospy's, which follows /clock where /use_sim_time is set
    :returns: the scheduler; the node must have been initialised
    """
    with _schedulers_lock:
        is_simulated = not (steady or rospy.rostime.is_wallclock())
        if is_simulated not in _schedulers:
            clock: AnyClock = SimulatedClock() if is_simulated else MonotonicClock()
            _schedulers[is_simulated] = Scheduler(clock)
        return _schedulers[is_simulated]
