"""Timers of a node, which run in a callback group and can follow its parameters."""

import itertools
import threading
from typing import Any, Callable, Dict, Iterable, List, Optional, Tuple, Union

import rospy

from nodekit.groups.callback_groups import CallbackGroup
from nodekit.groups.ready_queue import ReadyQueue
from nodekit.node.callbacks import Callback
from nodekit.timing.scheduler import Scheduler, Timer

#: A rate in Hz, or a function that returns it.
Rate = Union[float, Callable[[], float]]


class NodeTimer(Callback):
    """Callback that is called at a fixed rate, in a group.

    If the group is taken when a call is due, the thread that leaves it makes the call, or the
    executor when it can; further ticks until then are skipped and counted.

    :param scheduler: dispatches the calls when they are due
    :param group: the function's group
    :param rate: calls per second [Hz], or a function that returns it; 0 pauses
    :param callback: called with the time since the first call [s]
    :param catch_up: lateness up to which missed calls are made up for [s]
    :param what: names it in the log
    :raises ValueError: if a timer cannot keep the rate
    """

    kind = "timer"
    takes = 1

    def __init__(
        self,
        scheduler: Scheduler,
        group: CallbackGroup,
        rate: Rate,
        callback: Callable[[float], Any],
        catch_up: float,
        what: str,
    ) -> None:
        super().__init__(group, callback, what)
        first = 0.0 if callable(rate) else rate
        self._timer = Timer(scheduler, self.call_inside, first, catch_up, group.offer)
        self._scheduler = scheduler
        self._rate = rate
        self._is_started = False
        self._lock = threading.Lock()  # held only to set a rate
        #: Numbers of the calls of the rate function, in order.
        self._queries = itertools.count(1)
        #: Number of the latest query whose rate is set.
        self._answered = 0

    def attach(self, ready: Optional[ReadyQueue]) -> None:
        """Set the executor that makes the calls; see :meth:`.Callback.attach`."""
        super().attach(ready)
        calls = self.calls
        self._timer.dispatch = self.group.offer if calls is None else calls.put

    def _drop(self, _thing: Any) -> None:
        self._timer.forget_one()

    @property
    def skipped(self) -> int:
        """Number of calls skipped so far because they were late."""
        return self._timer.skipped

    def set_rate(self, rate: float) -> None:
        """Change the rate with immediate effect.

        :param rate: calls per second [Hz]; 0 pauses
        :raises ValueError: if a timer cannot keep it; the old rate stays
        """
        self._timer.set_rate(rate)

    def update_rate(self) -> None:
        """Call the rate function, if there is one; keep the old rate if it raises an exception."""
        if callable(self._rate) and self._is_started and not self.closed:
            query = next(self._queries)
            try:
                rate = self._rate()
                with self._lock:
                    if query > self._answered:  # else a later query has set its rate
                        self._answered = query
                        self._timer.set_rate(rate)
            except Exception as error:
                rospy.logerr("%s: rate unchanged: %s: %s", self.what, type(error).__name__, error)

    def close(self) -> None:
        """Stop the timer, and start no new calls."""
        super().close()
        self._timer.close()

    @staticmethod
    def start_together(timers: Iterable["NodeTimer"]) -> None:
        """Start timers together; see :meth:`.Scheduler.start`.

        :param timers: new ones
        """
        by_scheduler: Dict[Scheduler, List[Timer]] = {}
        for timer in timers:
            timer._is_started = True
            timer.update_rate()
            by_scheduler.setdefault(timer._scheduler, []).append(timer._timer)
        for scheduler, started in by_scheduler.items():
            scheduler.start(started)


class ParameterRates:
    """Rates of timers that follow the parameters of a node."""

    __slots__ = ("_timers",)

    def __init__(self) -> None:
        self._timers: Tuple[NodeTimer, ...] = ()

    def add(self, timer: NodeTimer) -> None:
        """Update a timer until it is closed.

        :param timer: a timer whose rate is a function
        """
        self._timers = (*(other for other in self._timers if not other.closed), timer)

    def update(self) -> None:
        """Update all rates after a change of parameters."""
        for timer in self._timers:
            timer.update_rate()
