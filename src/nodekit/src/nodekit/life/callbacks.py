"""A user's function as nodekit calls it: in its group, guarded, and no more once it is closed."""

import time
import traceback
from collections import deque
from typing import Any, Callable, Deque, List

import rospy

from nodekit.life.groups import Group

#: A callback's failures are logged at most this often, s.
LOG_PERIOD_S = 5.0
#: Messages of the same process that are kept for a callback that is busy; the newest ones.
MOST_KEPT = 10_000


class Callback:
    """A function that is called in a group until it is closed.

    :param group: its group
    :param function: the function
    :param what: names it in the log
    """

    def __init__(self, group: Group, function: Callable[..., Any], what: str) -> None:
        self.group = group
        self.function = function
        self.closed = False
        #: How often it has raised something.
        self.failures = 0
        self._what = what
        self._quiet_until = 0.0

    def call(self, *arguments: Any) -> None:
        """Call the function when it is its turn; what it raises is logged and harms nothing else.

        :param arguments: what to call it with
        """
        self.group.enter()
        try:
            self.call_inside(*arguments)
        finally:
            self.group.leave()

    def call_inside(self, *arguments: Any) -> None:
        """Call the function from within the group, as :meth:`call` does.

        :param arguments: what to call it with
        """
        if self.closed:
            return
        try:
            self.function(*arguments)
        except BaseException:  # SystemExit too: it would end a thread that others rely on
            self.failures += 1
            self._log_failure()

    def close(self) -> None:
        """Begin no call any more; one that is under way goes on."""
        self.closed = True

    def _log_failure(self) -> None:
        now = time.monotonic()
        if now >= self._quiet_until and not rospy.is_shutdown():
            self._quiet_until = now + LOG_PERIOD_S
            text = "%s failed, %d times by now:\n%s"
            rospy.logerr(text, self._what, self.failures, traceback.format_exc())


class Answering(Callback):
    """A function whose result, or exception, somebody waits for."""

    def answer(self, request: Any) -> Any:
        """Call the function when it is its turn.

        :param request: what to call it with
        :returns: what it returns
        :raises rospy.ServiceException: if it is closed
        :raises Exception: whatever the function raises
        """
        self.group.enter()
        try:
            if self.closed:
                raise rospy.ServiceException(f"{self._what} is closed")
            return self.function(request)
        finally:
            self.group.leave()


class Bell(Callback):
    """A function to be called because of something new, once for all that is new by then.

    Ringing never waits: if the group is taken, the thread that leaves it calls the function.
    """

    def __init__(self, group: Group, function: Callable[[], Any], what: str) -> None:
        super().__init__(group, function, what)
        self._rung = False

    def ring(self) -> None:
        """Have the function called, after all that is new by now was noted."""
        if not self._rung:
            self._rung = True
            self.group.offer(self._answer)

    def _answer(self) -> None:
        self._rung = False  # before: what comes from now on may be missed by this call
        self.call_inside()


class Receiving(Callback):
    """A function that messages are handed to, one by one or all that came together.

    :param batches: whether it takes lists
    """

    def __init__(
        self, group: Group, function: Callable[[Any], Any], what: str, batches: bool
    ) -> None:
        super().__init__(group, function, what)
        self._batches = batches
        self._kept: Deque[Any] = deque(maxlen=MOST_KEPT)
        self._bell = Bell(group, self._receive_kept, what)

    def receive(self, messages: List[Any], may_wait: bool) -> None:
        """Hand messages over.

        :param messages: the messages, oldest first
        :param may_wait: whether the calling thread serves nobody else. One that has published
            these in a callback of its own must not: two nodes of one process would wait for each
            other.
        """
        if not may_wait:
            if not self._kept and self.group.try_enter():
                self._hand_over(messages)
                self.group.leave()
                return
            if len(self._kept) + len(messages) > MOST_KEPT:
                rospy.logwarn_throttle_identical(
                    10.0, f"{self._what} does not keep up: messages are lost"
                )
            self._kept.extend(messages)
            self._bell.ring()
        elif self._batches:
            self.call(messages)
        else:
            for message in messages:
                self.call(message)

    def _receive_kept(self) -> None:
        kept = self._kept
        while kept:
            self._hand_over([kept.popleft() for _ in range(len(kept))])

    def _hand_over(self, messages: List[Any]) -> None:
        if self._batches:
            self.call_inside(messages)
        else:
            for message in messages:
                self.call_inside(message)
