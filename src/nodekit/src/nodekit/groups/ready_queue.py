"""Ready queue of an executor, and the call queue of each callback.

Each subscription, timer or service has a call queue for waiting items. The call queue requests
admission to its group, and is ready only when the group is reserved for it: so no thread of the
executor ever waits for a group. The ready queue is first in, first out, but urgent groups precede
all others. A call queue with more items goes to the end, so that a slow subscription with many
messages does not hold up a timer.
"""

import threading
import time
from collections import deque
from functools import partial
from typing import Any, Callable, Deque, List, NamedTuple, Optional, Set

from nodekit.groups.callback_groups import CallbackGroup


class _WaitingItem(NamedTuple):
    """Waiting item, with its time of arrival on the monotonic clock [s]."""

    thing: Any
    at: float


class CallQueue:
    """Queue of the items that wait for one callback.

    :param ready: where it waits for a thread once its group is reserved for it
    :param group: its group
    :param depth: most waiting items; more drop the oldest
    :param run: makes one call for a list of items, inside the group; raises nothing
    :param drop: called with each dropped item; raises nothing
    :param together: whether one call is made for all waiting items

    :ivar running: number of running calls
    :ivar made: number of calls begun
    :ivar dropped: number of dropped items
    :ivar longest: longest call [s]
    :ivar longest_wait: longest time from an arrival to its call [s]
    """

    def __init__(
        self,
        ready: "ReadyQueue",
        group: CallbackGroup,
        depth: int,
        run: Callable[[List[Any]], None],
        drop: Callable[[Any], None],
        together: bool = False,
    ) -> None:
        self.ready, self.group, self.depth = ready, group, depth
        self.run, self.drop = run, drop
        self.running = self.made = self.dropped = 0
        self.longest = self.longest_wait = 0.0
        self._most_at_once = depth if together else 1
        self._waiting: Deque[_WaitingItem] = deque()
        self._requested = False

    @property
    def waiting(self) -> int:
        """Number of waiting items."""
        return len(self._waiting)

    def put(self, thing: Any) -> None:
        """Add an item.

        :param thing: item for ``run`` or ``drop``
        """
        self.ready.put(self, thing)

    # For the ready queue, which holds its lock:

    def add(self, thing: Any) -> List[Any]:
        """Add a waiting item; return the items dropped for it."""
        dropped = [self._waiting.popleft().thing] if len(self._waiting) >= self.depth else []
        self._waiting.append(_WaitingItem(thing, time.monotonic()))
        return dropped

    def begin_call(self) -> List[Any]:
        """Return the items of the next call, which begins now."""
        count = min(self._most_at_once, len(self._waiting))
        self.longest_wait = max(self.longest_wait, time.monotonic() - self._waiting[0].at)
        self.made += 1
        self.running += 1
        self._requested = False
        return [self._waiting.popleft().thing for _ in range(count)]

    def must_request(self) -> bool:
        """Return whether to request admission now: an item waits, and no request is pending."""
        requested, self._requested = self._requested, bool(self._waiting)
        return self._requested and not requested


class ReadyCall(NamedTuple):
    """Call that is ready to be made.

    :param calls: queue of the callback
    :param things: items of the call
    """

    calls: CallQueue
    things: List[Any]


class ReadyQueue:
    """Queue of the call queues whose groups are reserved for them; thread-safe."""

    def __init__(self) -> None:
        lock = threading.Lock()
        self._arrived, self._finished = threading.Condition(lock), threading.Condition(lock)
        self._urgent: Deque[CallQueue] = deque()
        self._usual: Deque[CallQueue] = deque()
        self._unfinished = 0  # number of items waiting or running
        #: Threads that make its calls.
        self.workers: Set[threading.Thread] = set()
        self._is_closed = self._is_over = False
        self._dropping: Set[int] = set()  # threads that drop remaining items

    def is_served_by_caller_alone(self) -> bool:
        """Return whether the calling thread is the only worker."""
        return self.workers == {threading.current_thread()}

    def put(self, calls: CallQueue, thing: Any) -> None:
        """Add an item to a call queue; drop it if this queue is closed.

        :param calls: the call queue
        :param thing: the item
        """
        dropped = [thing]
        with self._arrived:
            if not self._is_closed:
                dropped = calls.add(thing)
                self._unfinished += 1 - len(dropped)
            calls.dropped += len(dropped)
            must_request = calls.must_request()
        if must_request:
            self._request_admission(calls)
        for one in dropped:
            calls.drop(one)

    def next_call(self, wait: bool = True) -> Optional[ReadyCall]:
        """Return the next call, for :meth:`make_call`.

        :param wait: whether to wait for one
        :returns: None if no call is ready, or the queue is closed
        """
        with self._arrived:
            while not (self._urgent or self._usual):
                if self._is_over or not wait:
                    return None
                self._arrived.wait()
            calls = (self._urgent or self._usual).popleft()
            things = calls.begin_call()
            must_request = calls.must_request()
        if must_request:
            self._request_admission(calls)
        return ReadyCall(calls, things)

    def make_call(self, call: ReadyCall) -> None:
        """Make a call.

        :param call: result of :meth:`next_call`
        """
        calls, things = call
        calls.group.adopt()
        began = time.monotonic()
        try:
            if self._is_over:
                for thing in things:
                    calls.drop(thing)
            else:
                calls.run(things)
        finally:
            calls.group.leave()
            with self._arrived:
                calls.longest = max(calls.longest, time.monotonic() - began)
                calls.running -= 1
                self._unfinished -= len(things)
                if not self._unfinished:
                    self._finished.notify_all()

    def close(self, timeout: float) -> bool:
        """Accept no new items, and wait until all calls are made; then drop the waiting items.

        :param timeout: longest wait [s]
        :returns: whether all calls were made
        """
        with self._arrived:
            self._is_closed = True
            is_done = self._finished.wait_for(lambda: not self._unfinished, timeout)
            self._is_over = True
            self._arrived.notify_all()
        self._drop_rest()
        return is_done

    def _request_admission(self, calls: CallQueue) -> None:
        calls.group.admit(partial(self._append, calls))

    def _append(self, calls: CallQueue) -> None:
        with self._arrived:
            (self._urgent if calls.group.urgent else self._usual).append(calls)
            self._arrived.notify()
            is_over = self._is_over
        if is_over:  # the workers may have ended
            self._drop_rest()

    def _drop_rest(self) -> None:
        me = threading.get_ident()
        if me in self._dropping:  # a recursive call: the outer loop drops the rest
            return
        self._dropping.add(me)
        call = self.next_call(wait=False)
        while call is not None:
            self.make_call(call)
            call = self.next_call(wait=False)
        self._dropping.discard(me)
