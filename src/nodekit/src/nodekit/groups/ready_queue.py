"""What waits to be called by an executor, and whose turn it is; without a thread of its own.

Each subscription, timer or service keeps what waits for it in a call queue. That asks its group to
be let in, and is ready only when the group is kept for it: so no thread of the executor ever waits
for a group. In the ready queue, the first comes first, but those of urgent groups come before all
others. A call queue that has more goes to the end: so a timer is not kept from its turns by a slow
subscription with many messages.
"""

import threading
import time
from collections import deque
from functools import partial
from typing import Any, Callable, Deque, List, NamedTuple, Optional, Set

from nodekit.groups.callback_groups import CallbackGroup


class _Arrival(NamedTuple):
    """Something that waits, since a time on the monotonic clock, s."""

    thing: Any
    at: float


class CallQueue:
    """What the calls of one callback are made for.

    :param ready: where it waits for a thread, when its group is kept for it
    :param group: its group
    :param depth: how much may wait; of more, the newest is kept
    :param run: makes one call for a list of things, inside the group; raises nothing
    :param drop: is told of what no call is made for; raises nothing
    :param together: whether one call is made for all that waits

    :ivar running: calls under way
    :ivar made: calls begun
    :ivar dropped: how much was dropped
    :ivar longest: longest call, s
    :ivar longest_wait: longest time from an arrival to its call, s
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
        self._waiting: Deque[_Arrival] = deque()
        self._asks = False

    @property
    def waiting(self) -> int:
        """How much waits."""
        return len(self._waiting)

    def put(self, thing: Any) -> None:
        """Have a call made for something.

        :param thing: what ``run`` and ``drop`` know
        """
        self.ready.put(self, thing)

    # For the ready queue, which has locked itself:

    def add(self, thing: Any) -> List[Any]:
        """Add something that waits; return what is dropped for it."""
        dropped = [self._waiting.popleft().thing] if len(self._waiting) >= self.depth else []
        self._waiting.append(_Arrival(thing, time.monotonic()))
        return dropped

    def begin_call(self) -> List[Any]:
        """Return what the next call is made for, which begins now."""
        count = min(self._most_at_once, len(self._waiting))
        self.longest_wait = max(self.longest_wait, time.monotonic() - self._waiting[0].at)
        self.made += 1
        self.running += 1
        self._asks = False
        return [self._waiting.popleft().thing for _ in range(count)]

    def must_ask(self) -> bool:
        """Tell whether it is to ask its group now: if something waits, and it does not already."""
        asks, self._asks = self._asks, bool(self._waiting)
        return self._asks and not asks


class ReadyCall(NamedTuple):
    """A call to be made.

    :param calls: whose
    :param things: what it is made for
    """

    calls: CallQueue
    things: List[Any]


class ReadyQueue:
    """The call queues whose groups are kept for them; any thread may call its methods."""

    def __init__(self) -> None:
        lock = threading.Lock()
        self._news, self._finished = threading.Condition(lock), threading.Condition(lock)
        self._urgent: Deque[CallQueue] = deque()
        self._usual: Deque[CallQueue] = deque()
        self._unfinished = 0  # how much waits or is under way
        #: Threads that take from it.
        self.workers: Set[threading.Thread] = set()
        self._is_closed = self._is_over = False
        self._dropping: Set[int] = set()  # threads that drop what is left

    def is_served_by_caller_alone(self) -> bool:
        """Tell whether all that waits has to wait for the calling thread."""
        return self.workers == {threading.current_thread()}

    def put(self, calls: CallQueue, thing: Any) -> None:
        """Have a call made for something, unless this is closed.

        :param calls: where it waits
        :param thing: see :class:`CallQueue`
        """
        dropped = [thing]
        with self._news:
            if not self._is_closed:
                dropped = calls.add(thing)
                self._unfinished += 1 - len(dropped)
            calls.dropped += len(dropped)
            must_ask = calls.must_ask()
        if must_ask:
            self._ask(calls)
        for one in dropped:
            calls.drop(one)

    def next_call(self, wait: bool = True) -> Optional[ReadyCall]:
        """Return the next call to be made, which is then to be given to :meth:`make_call`.

        :param wait: whether to wait until there is one
        :returns: None if there is none, or will be none as this is closed
        """
        with self._news:
            while not (self._urgent or self._usual):
                if self._is_over or not wait:
                    return None
                self._news.wait()
            calls = (self._urgent or self._usual).popleft()
            things = calls.begin_call()
            must_ask = calls.must_ask()
        if must_ask:
            self._ask(calls)
        return ReadyCall(calls, things)

    def make_call(self, turn: ReadyCall) -> None:
        """Make a call.

        :param turn: from :meth:`next_call`
        """
        calls, things = turn
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
            with self._news:
                calls.longest = max(calls.longest, time.monotonic() - began)
                calls.running -= 1
                self._unfinished -= len(things)
                if not self._unfinished:
                    self._finished.notify_all()

    def close(self, timeout: float) -> bool:
        """Take in nothing more, and wait until all calls are made; drop what then still waits.

        :param timeout: longest wait, s
        :returns: whether all calls were made
        """
        with self._news:
            self._is_closed = True
            is_done = self._finished.wait_for(lambda: not self._unfinished, timeout)
            self._is_over = True
            self._news.notify_all()
        self._drop_rest()
        return is_done

    def _ask(self, calls: CallQueue) -> None:
        calls.group.admit(partial(self._append, calls))

    def _append(self, calls: CallQueue) -> None:
        with self._news:
            (self._urgent if calls.group.urgent else self._usual).append(calls)
            self._news.notify()
            is_over = self._is_over
        if is_over:  # there may be no thread left
            self._drop_rest()

    def _drop_rest(self) -> None:
        me = threading.get_ident()
        if me in self._dropping:  # it has left a group, whose next one its loop comes to
            return
        self._dropping.add(me)
        turn = self.next_call(wait=False)
        while turn is not None:
            self.make_call(turn)
            turn = self.next_call(wait=False)
        self._dropping.discard(me)
