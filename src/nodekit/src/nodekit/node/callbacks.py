"""Callbacks of subscriptions, services and actions: user functions, called in callback groups."""

import threading
import time
from concurrent.futures import Future
from typing import Any, Callable, List, Optional, Tuple

import rospy

from nodekit.argument_checks import check_function
from nodekit.groups.callback_groups import CallbackGroup, NoGroup
from nodekit.groups.ready_queue import CallQueue, ReadyQueue
from nodekit.messaging.callback_errors import CallbackErrors
from nodekit.messaging.finite import is_finite
from nodekit.messaging.rate_limited_log import shortened
from nodekit.node import fork_guard
from nodekit.process_context import PROCESS
from nodekit.throttle import Throttle

#: Most messages kept for a busy callback, from publishers of the same process; the newest.
MOST_KEPT = 10_000
#: Default of how many messages wait for an executor; the newest.
DEPTH = 10
#: A message that waits longer than this for its callback is warned of [s].
LATE_S = 1.0
#: Least time between two warnings about messages that are ignored [s].
_WARN_EVERY_S = 10.0
#: Most calls of a service that wait for an executor: each has a thread and a connection.
MOST_CALLS = 1000


def check_queue_size(queue_size: Optional[int]) -> None:
    """Check a queue size.

    :param queue_size: the user's value, None if unset, -1 for no limit
    :raises ValueError: if it is neither positive nor -1
    """
    if queue_size in (None, -1) or (isinstance(queue_size, int) and queue_size > 0):
        return
    allowed = "must be a whole number of at least 1, or -1 for no limit"
    raise ValueError(f"queue_size: refused {queue_size!r}: {allowed}")


def finite_only(callback: Callable[[Any], Any], topic: str) -> Callable[[Any], None]:
    """Return a callback that ignores, with a warning, messages with NaN or infinity in a field.

    :param callback: called with the other messages
    :param topic: names the messages in the log
    """
    throttle = Throttle(_WARN_EVERY_S)

    def call_if_finite(message: Any) -> None:
        if is_finite(message):
            callback(message)
        elif throttle.is_due():
            text = shortened(" ".join(str(message).split()))
            rospy.logwarn("%s: %s is not finite and is ignored", topic, text)

    return call_if_finite


class Callback:
    """A function that is called in a group until it is closed.

    :param group: its group
    :param function: the function
    :param what: names it in the log
    :raises TypeError: if the function is not callable, or async

    :ivar errors: the exceptions it has raised
    :ivar calls: its queue at an executor, None without one
    """

    #: Type of the callback in reports.
    kind = "callback"
    #: Number of arguments of its function, if that is the same for the whole class.
    takes: Optional[int] = None

    def __init__(self, group: CallbackGroup, function: Callable[..., Any], what: str) -> None:
        check_function(function, what, self.takes)
        self.group = group
        self.function = function
        self.closed = False
        self.errors = CallbackErrors()
        self.calls: Optional[CallQueue] = None
        self.what = what

    def attach(self, ready: Optional[ReadyQueue]) -> None:
        """Set the executor that makes the calls; waiting calls stay with the old one.

        :param ready: the executor's queue, None for rospy's threads
        """
        is_attached = ready is not None and not isinstance(self.group, NoGroup)
        self.calls = self._new_queue(ready) if ready is not None and is_attached else None

    def _new_queue(self, ready: ReadyQueue) -> CallQueue:
        return CallQueue(ready, self.group, MOST_KEPT, lambda works: works[0](), self._drop)

    def _drop(self, _thing: Any) -> None:
        """Handle an item that an executor drops, because its queue is full or it is shut down."""

    def offer(self, work: Callable[[], None]) -> None:
        """Do some work in the group without waiting.

        :param work: what to do; raises nothing
        """
        calls = self.calls
        if calls is None:
            self.group.offer(work)
        else:
            calls.put(work)

    def call(self, *arguments: Any) -> None:
        """Call the function in its group; log an exception instead of raising it.

        :param arguments: its arguments
        """
        group = self.group
        group.enter()
        try:  # a copy of call_inside, which saves a call per message
            if not self.closed:
                fork_guard.call(self.function, *arguments)
        except BaseException:
            self.errors.record(self.what, self.closed)
        finally:
            group.leave()

    def call_inside(self, *arguments: Any) -> None:
        """Call the function as :meth:`call` does, from inside the group.

        :param arguments: its arguments
        """
        try:
            if not self.closed:
                fork_guard.call(self.function, *arguments)
        except BaseException:  # SystemExit too: it would end a thread that others rely on
            self.errors.record(self.what, self.closed)

    def close(self) -> None:
        """Start no new calls; let a running one finish."""
        self.closed = True


class ServiceCallback(Callback):
    """Callback of a service, whose caller waits for the result or exception."""

    kind = "service"
    takes = 1

    def __init__(self, group: CallbackGroup, function: Callable[[Any], Any], what: str) -> None:
        super().__init__(group, function, what)
        PROCESS.by_name(ServiceCallback)[what] = self

    def waits_for_caller(self) -> bool:
        """Return whether a call made now would wait for the calling thread."""
        is_its_thread = self.calls is not None and self.calls.ready.is_served_by_caller_alone()
        return not self.closed and (self.group.is_mine or is_its_thread)

    def _new_queue(self, ready: ReadyQueue) -> CallQueue:
        return CallQueue(ready, self.group, MOST_CALLS, self._respond_queued, self._reject)

    def respond(self, request: Any) -> Any:
        """Call the function in its group, and return its result.

        :param request: its argument
        :raises rospy.ServiceException: if it is closed, or the function raises an exception
        """
        calls = self.calls
        if calls is not None:
            answer: "Future[Any]" = Future()
            calls.put((request, answer))
            return answer.result()
        self.group.enter()
        try:
            return self._respond_inside(request)
        finally:
            self.group.leave()

    def _respond_inside(self, request: Any) -> Any:
        if self.closed:
            raise rospy.ServiceException(f"{self.what} is closed")
        try:
            return fork_guard.call(self.function, request)
        except rospy.ServiceException:
            raise
        except BaseException as error:  # SystemExit too: the client would wait for its response
            self.errors.record(self.what, self.closed)
            raise rospy.ServiceException(str(error) or repr(error)) from error

    def _respond_queued(self, calls: "List[Tuple[Any, Future[Any]]]") -> None:
        ((request, answer),) = calls
        try:
            answer.set_result(self._respond_inside(request))
        except BaseException as error:
            answer.set_exception(error)

    def _reject(self, call: "Tuple[Any, Future[Any]]") -> None:
        text = f"{self.what}: too many calls wait, or its executor is shut down"
        call[1].set_exception(rospy.ServiceException(text))


class CoalescingCallback(Callback):
    """A function that is called once for any number of triggers since its last call.

    A trigger never waits: if the group is taken, the thread that leaves it calls the function.
    """

    _triggered = False

    def trigger(self) -> None:
        """Call the function, now or when the group is free."""
        if not self._triggered:
            self._triggered = True
            self.offer(self._call_once)

    def _drop(self, _thing: Any) -> None:
        self._triggered = False

    def _call_once(self) -> None:
        self._triggered = False  # before the call, which may miss later triggers
        self.call_inside()


class SubscriptionCallback(Callback):
    """Callback of a subscription, for single messages or batches.

    :param batches: whether the function takes lists
    :param queue_size: most messages that wait, the newest; -1 for no limit but
        :data:`MOST_KEPT`. None for :data:`DEPTH` with an executor; without one, the messages of
        other processes wait at their sender
    """

    kind = "subscription"
    takes = 1

    def __init__(
        self,
        group: CallbackGroup,
        function: Callable[[Any], Any],
        what: str,
        batches: bool,
        queue_size: Optional[int] = None,
    ) -> None:
        super().__init__(group, function, what)
        self._batches, self._queue_size = batches, queue_size
        #: Whether only the newest messages are to wait, without an executor too.
        self.newest_only = queue_size is not None and queue_size > 0
        self._depth = queue_size if queue_size is not None and queue_size > 0 else MOST_KEPT
        self._keeping = threading.Lock()  # held only to add or take messages
        self._kept: List[Any] = []  # mostly empty: a list takes a tenth of a deque's memory then
        self._kept_at: List[float] = []  # monotonic time of the arrival of each [s]
        self._has_thread = self._is_late_reported = False
        self._retry = CoalescingCallback(group, self._deliver_kept, what)
        self._throttle = Throttle(10.0)

    def _new_queue(self, ready: ReadyQueue) -> CallQueue:
        depth = DEPTH if self._queue_size is None else self._depth
        return CallQueue(ready, self.group, depth, self._deliver_queued, self._drop, self._batches)

    def receive(self, messages: List[Any], may_wait: bool) -> None:
        """Pass messages to the function.

        :param messages: the messages, oldest first
        :param may_wait: whether the calling thread may wait for the group. A thread that published
            them in a callback may not: two nodes of one process would wait for each other.
        """
        calls = self.calls
        if calls is not None:
            for message in messages:
                calls.put(message)
        elif may_wait and not self.newest_only:
            arrived_at = time.monotonic()
            for message in [messages] if self._batches else messages:
                self.group.enter()
                self._call_inside_since(arrived_at, message)
                self.group.leave()
        elif not self._kept and self.group.try_enter():
            arrived_at = time.monotonic()
            self._deliver(messages[-self._depth :] if self.newest_only else messages, arrived_at)
            self.group.leave()
        else:
            self._keep(messages)
            if may_wait:  # the calling thread must return to reading, or its messages grow old
                self._deliver_in_thread()
            else:
                self._retry.trigger()

    def _keep(self, messages: List[Any]) -> None:
        with self._keeping:
            self._kept += messages
            self._kept_at += [time.monotonic()] * len(messages)
            lost = max(0, len(self._kept) - self._depth)
            del self._kept[:lost], self._kept_at[:lost]
        if lost and not self.newest_only and self._throttle.is_due():
            rospy.logwarn("%s: callback is too slow, messages are dropped", self.what)

    def _deliver_in_thread(self) -> None:
        """Deliver the kept messages in a thread that waits for the group; start only one."""
        with self._keeping:
            if not self._has_thread:
                threading.Thread(target=self._wait_and_deliver, name=self.what, daemon=True).start()
                self._has_thread = True

    def _wait_and_deliver(self) -> None:
        self.group.enter()
        with self._keeping:
            self._has_thread = False  # before the delivery, which may miss later messages
        self._deliver_kept()
        self.group.leave()

    def _deliver_kept(self) -> None:
        while self._kept:
            with self._keeping:
                kept, self._kept = self._kept, []
                kept_at, self._kept_at = self._kept_at, []
            self._deliver(kept, kept_at[0])

    def _deliver_queued(self, messages: List[Any]) -> None:
        calls = self.calls
        waited = calls.longest_wait if calls is not None else 0.0
        self._deliver(messages, time.monotonic() - waited)

    def _deliver(self, messages: List[Any], arrived_at: float) -> None:
        for message in [messages] if self._batches else messages:
            self._call_inside_since(arrived_at, message)

    def _call_inside_since(self, arrived_at: float, message: Any) -> None:
        """Call the function from inside the group; warn once of messages that have waited.

        :param arrived_at: monotonic time of the message's arrival [s]
        :param message: the message, or a batch
        """
        age = time.monotonic() - arrived_at
        if age > LATE_S and not (self._is_late_reported or self.closed):
            self._is_late_reported = True
            advice = "" if self._depth == 1 else ", or set queue_size=1 to receive only the newest"
            rospy.logwarn(
                "%s: messages wait for their callback (%.1f s); "
                "shorten the callbacks of its group%s",
                self.what,
                age,
                advice,
            )
        try:  # a copy of call_inside, which saves a call per message
            if not self.closed:
                fork_guard.call(self.function, message)
        except BaseException:
            self.errors.record(self.what, self.closed)
