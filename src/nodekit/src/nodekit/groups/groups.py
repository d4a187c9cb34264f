"""Callback groups: which callbacks of a node may run at the same time.

rospy calls back from many threads: one for each connection, one for timers, one for each call of a
service. Callbacks of one exclusive group run one after the other all the same, in the order in
which they came, so that a node's class needs no lock of its own.

A group is not a lock. It is left to a thread that waits for it (a message, a call of a service) or
to work that was left with it (a tick, a change of parameters), which the leaving thread does
itself: so the threads that serve a whole process never wait for one node's callback. Or it is kept
for somebody who asked to be let in, an executor, which then finds a thread for it.
"""

import threading
from typing import Callable, Dict, List, NamedTuple, Union

#: Work that may be left with a group; raises nothing.
Work = Callable[[], None]


class _Waiting:
    """A thread that waits for its turn."""

    def __init__(self) -> None:
        self.thread = threading.get_ident()
        self.turn = threading.Lock()
        self.turn.acquire()


class _Asking(NamedTuple):
    """Somebody who is not kept waiting.

    :param admitted: called when it is their turn
    """

    admitted: Work


class Group:
    """One callback at a time, in the order of arrival; the group of rclpy's name.

    A thread that is inside enters again without waiting.

    :param urgent: whether an executor makes its callbacks before those of other groups
    """

    def __init__(self, urgent: bool = False) -> None:
        self.urgent = urgent
        # Who has it is inside. It is handed on locked, so that nobody comes in between.
        self._inside = threading.Lock()
        self._holder = 0  # of which thread the group is, 0 if it is free
        self._depth = 0  # how often that thread has entered again
        # Mostly empty, and there are many groups: a list is a tenth of a deque then.
        self._queue: List[Union[_Waiting, _Asking, Work]] = []

    def try_enter(self) -> bool:
        """Enter if the group is free; not again, where the calling thread is inside.

        :returns: whether the calling thread is inside now, and is to leave
        """
        if not self._inside.acquire(False):
            return False
        self._holder = threading.get_ident()
        return True

    def enter(self, timeout: float = -1.0) -> bool:
        """Wait until it is the calling thread's turn.

        :param timeout: longest wait, s; -1 for ever
        :returns: whether it is; False only where the time is over
        """
        me = threading.get_ident()
        if self._inside.acquire(False):  # as try_enter does; messages and ticks save the call
            self._holder = me
            return True
        if self._holder == me:
            self._depth += 1
            return True
        waiting = _Waiting()
        self._queue.append(waiting)
        self._serve_if_free()
        if waiting.turn.acquire(timeout=timeout):
            return True
        try:
            self._queue.remove(waiting)
        except ValueError:  # it is being handed over just now
            return waiting.turn.acquire()
        return False

    def leave(self) -> None:
        """Hand the group over; do what was left with it before."""
        if self._depth:
            self._depth -= 1
            return
        if self._queue and self._hand_on():
            return
        self._holder = 0
        self._inside.release()
        if self._queue:
            self._serve_if_free()

    def offer(self, work: Work) -> None:
        """Do some work at once or, if the group is taken, leave it to the thread that leaves.

        Never waits, and never does the work in the middle of a callback of the same thread.

        :param work: what to do
        """
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
        """Have the group kept for the caller, now or later.

        :param admitted: called once it is, in whatever thread; must be quick. Some thread is then
            to call :meth:`adopt` and :meth:`leave`.
        """
        self._queue.append(_Asking(admitted))
        self._serve_if_free()

    def adopt(self) -> None:
        """Be inside with the calling thread, after the group was kept for it."""
        self._holder = threading.get_ident()

    @property
    def is_mine(self) -> bool:
        """Whether the calling thread is inside, and all others must wait for it."""
        return self._holder == threading.get_ident()

    def _serve_if_free(self) -> None:
        """Serve the queue, which has got something at the moment when the last one left."""
        if self.try_enter():
            self.leave()

    def _hand_on(self) -> bool:
        """Do what is queued, up to somebody who wants in; tell whether they have the group now."""
        while self._queue:
            following = self._queue.pop(0)
            if isinstance(following, _Waiting):
                self._holder = following.thread
                following.turn.release()
                return True
            if isinstance(following, _Asking):
                self._holder = 0
                following.admitted()
                return True
            following()
        return False

    def wait_until_left(self, timeout: float) -> bool:
        """Wait for a callback that is under way, but not for one of the calling thread.

        :param timeout: longest wait, s
        :returns: whether it has ended
        """
        if not self._holder:  # it is free, or kept for a callback that has not begun
            return True
        if not self.enter(timeout):
            return False
        self.leave()
        return True

    def __enter__(self) -> "Group":
        self.enter()
        return self

    def __exit__(self, *_error: object) -> None:
        self.leave()


class ReentrantGroup(Group):
    """Any number of callbacks at a time, as rospy itself has it."""

    def __init__(self, urgent: bool = False) -> None:
        super().__init__(urgent)
        # How often each thread is inside. Only that thread changes it, so this takes no lock, which
        # would be most of the time that a short callback takes.
        self._depths: Dict[int, int] = {}
        self._left = threading.Condition()
        self._awaiting = 0  # how many threads wait for others to leave

    def try_enter(self) -> bool:
        """Go in."""
        return self.enter()

    def enter(self, timeout: float = -1.0) -> bool:
        """Go in without waiting."""
        me = threading.get_ident()
        self._depths[me] = self._depths.get(me, 0) + 1
        return True

    def leave(self) -> None:
        """Go out."""
        me = threading.get_ident()
        self._depths[me] -= 1
        if not self._depths[me]:
            del self._depths[me]
            if self._awaiting:  # who begins to wait from now on, does not find this thread
                with self._left:
                    self._left.notify_all()

    def offer(self, work: Work) -> None:
        """Do some work at once.

        :param work: what to do
        """
        self.enter()
        try:
            work()
        finally:
            self.leave()

    def admit(self, admitted: Work) -> None:
        """Call back at once; see :meth:`Group.admit`."""
        admitted()

    def adopt(self) -> None:
        """Go in."""
        self.enter()

    @property
    def is_mine(self) -> bool:
        """False: nobody waits for anybody."""
        return False

    def wait_until_left(self, timeout: float) -> bool:
        """Wait for all callbacks that are under way now; see :meth:`Group.wait_until_left`.

        :param timeout: longest wait, s
        :returns: whether they have ended
        """
        with self._left:
            self._awaiting += 1
            others = set(self._depths) - {threading.get_ident()}
            have_left = self._left.wait_for(lambda: not others & set(self._depths), timeout)
            self._awaiting -= 1
        return have_left


class Outside(ReentrantGroup):
    """For what a toolkit does for a node, and not the node's own class: no executor makes it."""
