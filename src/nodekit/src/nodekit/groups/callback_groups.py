"""Callback groups: which callbacks of a node may run at the same time.

rospy runs callbacks in many threads: one per connection, one for timers, one per call of a
service. Callbacks of a mutually exclusive group still run one after the other, in order of arrival,
so that a node's class needs no locks.

A group is not a lock. The thread that leaves it hands it over to the next in the queue:

- a waiting thread (a message, a call of a service), which then enters;
- queued work (a tick, a change of parameters), which the leaving thread does itself, so that
  threads that serve a whole process never wait for one node's callback;
- a request for admission (an executor), for which the group is reserved until a thread adopts it.
"""

import threading
from typing import Callable, Dict, List, NamedTuple, Union

#: Work that a group can queue; raises nothing.
Work = Callable[[], None]


class _WaitingThread:
    """A thread that waits for the group."""

    def __init__(self) -> None:
        self.thread = threading.get_ident()
        self.turn = threading.Lock()
        self.turn.acquire()


class _Admission(NamedTuple):
    """A request for admission, which does not block the caller.

    :param admitted: called when the group is reserved
    """

    admitted: Work


class CallbackGroup:
    """Base class of callback groups; a ``with`` statement enters and leaves the group.

    :param urgent: whether an executor runs its callbacks before those of other groups
    """

    def __init__(self, urgent: bool = False) -> None:
        self.urgent = urgent

    def try_enter(self) -> bool:
        """Enter if the group is free; do not enter again if the calling thread is inside.

        :returns: whether the calling thread has entered, and must leave
        """
        raise NotImplementedError

    def enter(self, timeout: float = -1.0) -> bool:
        """Wait until the calling thread can enter.

        :param timeout: longest wait [s]; -1 for no limit
        :returns: whether it has entered; False only after the timeout
        """
        raise NotImplementedError

    def leave(self) -> None:
        """Leave the group, and do the work queued for it meanwhile."""
        raise NotImplementedError

    def offer(self, work: Work) -> None:
        """Do some work inside the group without waiting, now or when a thread leaves it.

        The work is never done in the middle of a callback of the same thread.

        :param work: what to do
        """
        raise NotImplementedError

    def admit(self, admitted: Work) -> None:
        """Reserve the group for the caller, now or later.

        :param admitted: called in any thread once the group is reserved; must be short. Some thread
            must then call :meth:`adopt` and :meth:`leave`.
        """
        raise NotImplementedError

    def adopt(self) -> None:
        """Enter a group that was reserved, with the calling thread."""
        raise NotImplementedError

    @property
    def is_mine(self) -> bool:
        """Whether the calling thread is inside and all others must wait for it."""
        raise NotImplementedError

    def wait_until_left(self, timeout: float) -> bool:
        """Wait for running callbacks of other threads.

        :param timeout: longest wait [s]
        :returns: whether they have ended
        """
        raise NotImplementedError

    def __enter__(self) -> "CallbackGroup":
        self.enter()
        return self

    def __exit__(self, *_error: object) -> None:
        self.leave()


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """A group whose callbacks run one at a time, in order of arrival.

    A thread that is inside enters again without waiting.

    :param urgent: whether an executor runs its callbacks before those of other groups
    """

    def __init__(self, urgent: bool = False) -> None:
        super().__init__(urgent)
        # Held by the thread inside. It is handed over locked, so that no other thread enters first.
        self._inside = threading.Lock()
        self._holder = 0  # id of the thread inside, 0 if free
        self._depth = 0  # how often that thread has entered again
        # Mostly empty, and there are many groups: a list takes a tenth of a deque's memory then.
        self._queue: List[Union[_WaitingThread, _Admission, Work]] = []

    def try_enter(self) -> bool:
        """Enter if the group is free; see :meth:`CallbackGroup.try_enter`."""
        if not self._inside.acquire(False):
            return False
        self._holder = threading.get_ident()
        return True

    def enter(self, timeout: float = -1.0) -> bool:
        """Wait until the calling thread can enter; see :meth:`CallbackGroup.enter`."""
        me = threading.get_ident()
        if self._inside.acquire(False):  # as in try_enter, without the cost of that call
            self._holder = me
            return True
        if self._holder == me:
            self._depth += 1
            return True
        waiting = _WaitingThread()
        self._queue.append(waiting)
        self._serve_if_free()
        if waiting.turn.acquire(timeout=timeout):
            return True
        try:
            self._queue.remove(waiting)
        except ValueError:  # the group is being handed over just now
            return waiting.turn.acquire()
        return False

    def leave(self) -> None:
        """Hand the group over, and do the work queued before the next thread."""
        if self._depth:
            self._depth -= 1
            return
        if self._queue and self._hand_over():
            return
        self._holder = 0
        self._inside.release()
        if self._queue:
            self._serve_if_free()

    def offer(self, work: Work) -> None:
        """Do some work now, or in the thread that leaves; see :meth:`CallbackGroup.offer`."""
        if not self._inside.acquire(False):
            self._queue.append(work)
            self._serve_if_free()
            return
        self._holder = threading.get_ident()
        try:
            work()
        finally:
            self.leave()

    def admit(self, admitted: Work) -> None:
        """Reserve the group, now or later; see :meth:`CallbackGroup.admit`."""
        self._queue.append(_Admission(admitted))
        self._serve_if_free()

    def adopt(self) -> None:
        """Enter with the calling thread, after the group was reserved for it."""
        self._holder = threading.get_ident()

    @property
    def is_mine(self) -> bool:
        """Whether the calling thread is inside and all others must wait for it."""
        return self._holder == threading.get_ident()

    def _serve_if_free(self) -> None:
        """Serve the queue, in case an entry was added just as the last thread left."""
        if self.try_enter():
            self.leave()

    def _hand_over(self) -> bool:
        """Do queued work up to the first entry that takes the group; return whether one did."""
        while self._queue:
            entry = self._queue.pop(0)
            if isinstance(entry, _WaitingThread):
                self._holder = entry.thread
                entry.turn.release()
                return True
            if isinstance(entry, _Admission):
                self._holder = 0
                entry.admitted()
                return True
            entry()
        return False

    def wait_until_left(self, timeout: float) -> bool:
        """Wait for a running callback of another thread.

        :param timeout: longest wait [s]
        :returns: whether it has ended
        """
        if not self._holder:  # free, or reserved for a callback that has not begun
            return True
        if not self.enter(timeout):
            return False
        self.leave()
        return True


#: Short name of :class:`MutuallyExclusiveCallbackGroup`.
Group = MutuallyExclusiveCallbackGroup


class ReentrantCallbackGroup(CallbackGroup):
    """A group whose callbacks run at any time, also in parallel, as in rospy itself.

    :param urgent: whether an executor runs its callbacks before those of other groups
    """

    def __init__(self, urgent: bool = False) -> None:
        super().__init__(urgent)
        # How often each thread is inside. Only that thread changes its entry, so no lock is needed;
        # it would take most of the time of a short callback.
        self._depths: Dict[int, int] = {}
        self._left = threading.Condition()
        self._awaiting = 0  # how many threads wait for others to leave

    def try_enter(self) -> bool:
        """Enter without waiting."""
        return self.enter()

    def enter(self, timeout: float = -1.0) -> bool:
        """Enter without waiting."""
        me = threading.get_ident()
        self._depths[me] = self._depths.get(me, 0) + 1
        return True

    def leave(self) -> None:
        """Leave the group."""
        me = threading.get_ident()
        self._depths[me] -= 1
        if not self._depths[me]:
            del self._depths[me]
            if self._awaiting:  # a thread that begins to wait from now on does not see this one
                with self._left:
                    self._left.notify_all()

    def offer(self, work: Work) -> None:
        """Do some work immediately.

        :param work: what to do
        """
        self.enter()
        try:
            work()
        finally:
            self.leave()

    def admit(self, admitted: Work) -> None:
        """Call back immediately; see :meth:`CallbackGroup.admit`."""
        admitted()

    def adopt(self) -> None:
        """Enter with the calling thread."""
        self.enter()

    @property
    def is_mine(self) -> bool:
        """False: no thread waits for another."""
        return False

    def wait_until_left(self, timeout: float) -> bool:
        """Wait for all callbacks that are running now; see :meth:`CallbackGroup.wait_until_left`.

        :param timeout: longest wait [s]
        :returns: whether they have ended
        """
        with self._left:
            self._awaiting += 1
            others = set(self._depths) - {threading.get_ident()}
            have_left = self._left.wait_for(lambda: not others & set(self._depths), timeout)
            self._awaiting -= 1
        return have_left


class NoGroup(ReentrantCallbackGroup):
    """Group of nodekit's internal callbacks for a node; no executor runs them."""
