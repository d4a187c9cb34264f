"""The timers of a node: in its callback group, and following its parameters."""

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
    """A function that is called at a rate, in a group.

    Where the group is taken when a call is due, the thread that leaves it makes the call, or the
    executor when it can; a tick that comes meanwhile is left out, and counted.

    :param scheduler: who says when a call is due
    :param group: the function's group
    :param rate: calls a second, Hz; 0 pauses. Of a function the result, see :meth:`follow`
    :param callback: called with the time since the first call, s
    :param catch_up: lateness up to which calls are made up for, s
    :param what: names it in the log
    :raises ValueError: if the rate is a number that no timer can keep
    """

    kind = "timer"
    #: Held for a moment, while a rate is set; one for all.
    _lock = threading.Lock()
    #: Numbers the questions for rates.
    _questions = itertools.count(1)

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
        #: The latest question for its rate that was answered, and the rate set.
        self._answered = 0

    def attach(self, ready: Optional[ReadyQueue]) -> None:
        """Have the calls made by an executor, or none; see :meth:`.Callback.attach`."""
        super().attach(ready)
        calls = self.calls
        self._timer.dispatch = self.group.offer if calls is None else calls.put

    def _drop(self, _thing: Any) -> None:
        self._timer.forget_one()

    @property
    def skipped(self) -> int:
        """Calls that were left out so far, because they would have come too late."""
        return self._timer.skipped

    def set_rate(self, rate: float) -> None:
        """Change the rate with immediate effect.

        :param rate: calls a second, Hz; 0 pauses
        :raises ValueError: if it is not one to keep; the old one stays
        """
        self._timer.set_rate(rate)

    def follow(self) -> None:
        """Ask for the rate, where it is a function; one that fails leaves the old rate."""
        if callable(self._rate) and self._is_started:
            question = next(self._questions)
            try:
                rate = self._rate()
                with self._lock:
                    if question > self._answered:  # or it has been asked since, and answered
                        self._answered = question
                        self._timer.set_rate(rate)
            except Exception as error:
                rospy.logerr("%s keeps its rate: %s: %s", self.what, type(error).__name__, error)

    def close(self) -> None:
        """Make no call any more."""
        super().close()
        self._timer.close()

    @staticmethod
    def start_together(timers: Iterable["NodeTimer"]) -> None:
        """Begin to call timers; see :meth:`.Scheduler.start`.

        :param timers: new ones
        """
        by_scheduler: Dict[Scheduler, List[Timer]] = {}
        for timer in timers:
            timer._is_started = True
            timer.follow()
            by_scheduler.setdefault(timer._scheduler, []).append(timer._timer)
        for scheduler, started in by_scheduler.items():
            scheduler.start(started)


class ParameterRates:
    """The timers of a node whose rates follow its parameters."""

    __slots__ = ("_timers",)

    def __init__(self) -> None:
        self._timers: Tuple[NodeTimer, ...] = ()

    def add(self, timer: NodeTimer) -> None:
        """Have a timer follow until it is closed.

        :param timer: one whose rate is a function
        """
        self._timers = (*(other for other in self._timers if not other.closed), timer)

    def follow(self) -> None:
        """Ask for all rates, as parameters have changed."""
        for timer in self._timers:
            timer.follow()
