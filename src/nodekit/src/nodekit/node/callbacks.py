"""A user's function as nodekit calls it: in its group, guarded, and no more once it is closed."""

import threading
from concurrent.futures import Future
from typing import Any, Callable, List, Optional, Tuple
from weakref import WeakValueDictionary

import rospy

from nodekit.groups.callback_groups import CallbackGroup, NoGroup
from nodekit.groups.ready_queue import CallQueue, ReadyQueue
from nodekit.messaging.failures import Failures
from nodekit.messaging.throttle import Throttle
from nodekit.node import fork_guard
from nodekit.validation import check_function

#: Messages of the same process that are kept for a callback that is busy; the newest ones.
MOST_KEPT = 10_000
#: Messages that wait for an executor, where the user does not say how many; the newest ones.
DEPTH = 10
#: Calls of a service that wait for an executor: each has a thread and a connection already.
MOST_CALLS = 1000


def queue_depth(queue_size: Optional[int]) -> int:
    """Return how many messages may wait for an executor.

    :param queue_size: what the user has set, None if unset, -1 for no limit
    :raises ValueError: if it is neither positive nor -1
    """
    if queue_size is None:
        return DEPTH
    if queue_size == -1:
        return MOST_KEPT
    if isinstance(queue_size, int) and queue_size > 0:
        return queue_size
    allowed = "must be a whole number of at least 1, or -1 for no limit of its own"
    raise ValueError(f"queue_size: refused {queue_size!r}: {allowed}")


class Callback:
    """A function that is called in a group until it is closed.

    :param group: its group
    :param function: the function
    :param what: names it in the log
    :raises TypeError: if the function is none, or async

    :ivar failures: what it has raised
    :ivar calls: what waits for an executor, None without one
    """

    #: What it is, in reports.
    kind = "callback"

    def __init__(self, group: CallbackGroup, function: Callable[..., Any], what: str) -> None:
        check_function(function, what)
        self.group = group
        self.function = function
        self.closed = False
        self.failures = Failures()
        self.calls: Optional[CallQueue] = None
        self.what = what

    def attach(self, ready: Optional[ReadyQueue]) -> None:
        """Have the calls made by an executor, or none; what waits by then stays with the old one.

        :param ready: the executor's queue
        """
        is_attached = ready is not None and not isinstance(self.group, NoGroup)
        self.calls = self._new_queue(ready) if ready is not None and is_attached else None

    def _new_queue(self, ready: ReadyQueue) -> CallQueue:
        return CallQueue(ready, self.group, MOST_KEPT, lambda works: works[0](), self._drop)

    def _drop(self, _thing: Any) -> None:
        """Note that something is dropped: an executor has no time for it, or is shut down."""

    def offer(self, work: Callable[[], None]) -> None:
        """Have something done in the group without waiting.

        :param work: what to do; raises nothing
        """
        calls = self.calls
        if calls is None:
            self.group.offer(work)
        else:
            calls.put(work)

    def call(self, *arguments: Any) -> None:
        """Call the function when it is its turn; what it raises is logged and harms nothing else.

        :param arguments: what to call it with
        """
        group = self.group
        group.enter()
        try:  # in the steps of call_inside, which each message would else call once more
            if not self.closed:
                fork_guard.call(self.function, *arguments)
        except BaseException:
            self.failures.record(self.what, self.closed)
        finally:
            group.leave()

    def call_inside(self, *arguments: Any) -> None:
        """Call the function from within the group, as :meth:`call` does.

        :param arguments: what to call it with
        """
        try:
            if not self.closed:
                fork_guard.call(self.function, *arguments)
        except BaseException:  # SystemExit too: it would end a thread that others rely on
            self.failures.record(self.what, self.closed)

    def close(self) -> None:
        """Begin no call any more; one that is under way goes on."""
        self.closed = True


class ServiceCallback(Callback):
    """A function whose result, or exception, somebody waits for."""

    kind = "service"
    #: Those of this process by the name of their service.
    offered: "WeakValueDictionary[str, ServiceCallback]" = WeakValueDictionary()

    def __init__(self, group: CallbackGroup, function: Callable[[Any], Any], what: str) -> None:
        super().__init__(group, function, what)
        self.offered[what] = self

    def waits_for_caller(self) -> bool:
        """Tell whether a call now would have to wait for the calling thread."""
        is_its_thread = self.calls is not None and self.calls.ready.is_served_by_caller_alone()
        return not self.closed and (self.group.is_mine or is_its_thread)

    def _new_queue(self, ready: ReadyQueue) -> CallQueue:
        return CallQueue(ready, self.group, MOST_CALLS, self._answer_waiting, self._refuse)

    def answer(self, request: Any) -> Any:
        """Call the function when it is its turn.

        :param request: what to call it with
        :returns: what it returns
        :raises rospy.ServiceException: if it is closed, or the function raises something
        """
        calls = self.calls
        if calls is not None:
            answer: "Future[Any]" = Future()
            calls.put((request, answer))
            return answer.result()
        self.group.enter()
        try:
            return self._answer_inside(request)
        finally:
            self.group.leave()

    def _answer_inside(self, request: Any) -> Any:
        if self.closed:
            raise rospy.ServiceException(f"{self.what} is closed")
        try:
            return fork_guard.call(self.function, request)
        except rospy.ServiceException:
            raise
        except BaseException as error:  # SystemExit too: the client would wait for its answer
            self.failures.record(self.what, self.closed)
            raise rospy.ServiceException(str(error) or repr(error)) from error

    def _answer_waiting(self, calls: "List[Tuple[Any, Future[Any]]]") -> None:
        ((request, answer),) = calls
        try:
            answer.set_result(self._answer_inside(request))
        except BaseException as error:
            answer.set_exception(error)

    def _refuse(self, call: "Tuple[Any, Future[Any]]") -> None:
        text = f"{self.what}: too many calls wait, or its executor is shut down"
        call[1].set_exception(rospy.ServiceException(text))


class CoalescingCallback(Callback):
    """A function to be called because of something new, once for all that is new by then.

    Ringing never waits: if the group is taken, the thread that leaves it calls the function.
    """

    _rung = False

    def ring(self) -> None:
        """Have the function called, after all that is new by now was noted."""
        if not self._rung:
            self._rung = True
            self.offer(self._answer)

    def _drop(self, _thing: Any) -> None:
        self._rung = False

    def _answer(self) -> None:
        self._rung = False  # before: what comes from now on may be missed by this call
        self.call_inside()


class SubscriptionCallback(Callback):
    """A function that messages are handed to, one by one or all that came together.

    :param batches: whether it takes lists
    :param depth: messages that wait for an executor; the newest ones
    """

    kind = "subscription"
    _keeping = threading.Lock()  # one for all: held for a moment, while messages are kept or taken

    def __init__(
        self,
        group: CallbackGroup,
        function: Callable[[Any], Any],
        what: str,
        batches: bool,
        depth: int = DEPTH,
    ) -> None:
        super().__init__(group, function, what)
        self._batches, self._depth = batches, depth
        self._kept: List[Any] = []  # mostly empty, and then a tenth of a deque
        self._bell = CoalescingCallback(group, self._receive_kept, what)
        self._throttle = Throttle(10.0)

    def _new_queue(self, ready: ReadyQueue) -> CallQueue:
        return CallQueue(ready, self.group, self._depth, self._hand_over, self._drop, self._batches)

    def receive(self, messages: List[Any], may_wait: bool) -> None:
        """Hand messages over.

        :param messages: the messages, oldest first
        :param may_wait: whether the calling thread serves nobody else. One that has published
            these in a callback must not: two nodes of one process would wait for each other.
        """
        calls = self.calls
        if calls is not None:
            for message in messages:
                calls.put(message)
        elif not may_wait:
            if not self._kept and self.group.try_enter():
                self._hand_over(messages)
                self.group.leave()
                return
            with self._keeping:
                self._kept += messages
                lost = max(0, len(self._kept) - MOST_KEPT)
                del self._kept[:lost]
            if lost and self._throttle.is_due():
                rospy.logwarn("%s does not keep up: messages are lost", self.what)
            self._bell.ring()
        elif self._batches:
            self.call(messages)
        else:
            for message in messages:
                self.call(message)

    def _receive_kept(self) -> None:
        while self._kept:
            with self._keeping:
                kept, self._kept = self._kept, []
            self._hand_over(kept)

    def _hand_over(self, messages: List[Any]) -> None:
        if self._batches:
            self.call_inside(messages)
        else:
            for message in messages:
                self.call_inside(message)
