"""ClientGoalHandle: a goal that a client has sent, and the futures of its answers."""

import concurrent.futures
import contextlib
import threading
import time
from typing import Any, Callable, List, NamedTuple, Optional

from nodekit.actions.goal_states import CANCELING, ENDED, RUNNING, GoalState
from nodekit.argument_checks import check_function, check_timeout
from nodekit.node.action_types import GoalError, GoalTimeout

#: Default time-out of a cancellation's answer [s].
CANCEL_S = 5.0
#: A goal that was listed is lost after this many lists without it.
_MISSING_LISTS = 2


class GoalResult(NamedTuple):
    """End of a goal.

    :param status: its state: SUCCEEDED, ABORTED, PREEMPTED, REJECTED or RECALLED
    :param text: the server's comment on it
    :param result: of the action's result class
    """

    status: GoalState
    text: str
    result: Any


class GoalFuture(concurrent.futures.Future):
    """Future answer about a goal, which is done by its deadline.

    :param client: the :class:`.ActionClient`
    :param timeout: time-out of the answer [s]
    :param what: the answer, for the error
    """

    def __init__(self, client: Any, timeout: float, what: str) -> None:
        check_timeout(timeout)
        super().__init__()
        self._client, self._timeout, self._what = client, timeout, what
        self._deadline = time.monotonic() + timeout

    def result(self, timeout: Optional[float] = None) -> Any:
        """Wait for the answer.

        :param timeout: longest wait [s]; at most, and by default, up to the answer's own deadline
        :raises GoalTimeout: if there is no answer in time
        :raises GoalLost: if the server has gone
        :raises GoalError: if the client was closed, or the server waits for the calling thread
        """
        if not self.done():
            self._client.reject_nested()
        left = max(0.0, self._deadline - time.monotonic())
        wait = left if timeout is None else min(timeout, left)
        try:
            return super().result(wait)
        except concurrent.futures.CancelledError:
            raise GoalError(f"{self._client}: {self._what}: the wait was cancelled") from None
        except concurrent.futures.TimeoutError:
            raise self._late(self._timeout if wait == left else wait) from None

    def add_done_callback(self, function: Callable[["GoalFuture"], Any]) -> None:
        """Call a function with this future when it is done, in the client's callback group.

        :param function: the function
        :raises TypeError: if it is not callable, or async
        """
        check_function(function, f"{self._client}: add_done_callback", 1)
        super().add_done_callback(lambda _: self._client.offer(function, self))

    def expire(self, now: float) -> bool:
        """End the wait if its deadline has passed; return whether it has ended just now.

        :param now: monotonic time [s]
        """
        return now > self._deadline and self.settle(error=self._late(self._timeout))

    def settle(self, answer: Any = None, error: Optional[Exception] = None) -> bool:
        """Set the answer, or the error that :meth:`result` raises; return whether it is the first.

        :param answer: the answer
        :param error: the error, None for an answer
        """
        with contextlib.suppress(concurrent.futures.InvalidStateError):  # done or cancelled
            if error is None:
                self.set_result(answer)
            else:
                self.set_exception(error)
            return True
        return False

    def _late(self, timeout: float) -> GoalTimeout:
        return GoalTimeout(f"{self._client}: no {self._what} within {timeout:g} s")


class ClientGoalHandle:
    """A goal that a client has sent. Thread-safe.

    :param client: the :class:`.ActionClient`
    :param id: its id
    :param goal: the goal's message
    :param feedback_callback: called with its feedback, None without one
    :param timeout: longest time until it is accepted or rejected [s]

    :ivar goal_id: its id
    :ivar status: its latest known state
    :ivar text: the server's comment on that
    :ivar answer: the future with this handle, done once the goal is accepted or rejected
    :ivar is_sent: whether it was sent to a server
    :ivar ended_at: monotonic time at which its end was seen before its result, or None [s]
    """

    def __init__(
        self,
        client: Any,
        id: str,
        goal: Any,
        feedback_callback: Optional[Callable[[Any], Any]],
        timeout: float,
    ) -> None:
        self.goal_id, self.goal, self.feedback_callback = id, goal, feedback_callback
        self.status, self.text = GoalState.PENDING, ""
        self.answer = GoalFuture(client, timeout, "answer of a server")
        self.is_sent = False
        self.ended_at: Optional[float] = None
        self._client = client
        self._lock = threading.Lock()
        self._results: List[GoalFuture] = []
        self._cancels: List[GoalFuture] = []
        self._end: Optional[GoalResult] = None
        self._error: Optional[Exception] = None
        self._missing = 0  # lists without it since it was listed; 0 if it never was
        self._is_listed = False

    @property
    def accepted(self) -> bool:
        """Whether the server has accepted the goal; also after its end."""
        return self.status in RUNNING or (
            self.status in ENDED and self.status not in (GoalState.REJECTED, GoalState.RECALLED)
        )

    def get_result_async(self, timeout: float) -> GoalFuture:
        """Return the future :class:`GoalResult`; after a time-out the goal continues.

        :param timeout: longest time to the result [s]
        :raises ValueError: if the time-out is invalid
        """
        future = GoalFuture(self._client, timeout, "result")
        with self._lock:
            end, error = self._end, self._error
            if end is None and error is None:
                self._results.append(future)
        if end is not None or error is not None:
            future.settle(end, error)
        return future

    def get_result(self, timeout: float) -> GoalResult:
        """Wait for the result.

        :param timeout: longest wait [s]
        :raises GoalError: without a result, see :meth:`GoalFuture.result`
        """
        result: GoalResult = self.get_result_async(timeout).result()
        return result

    def cancel_goal_async(self, timeout: float = CANCEL_S) -> GoalFuture:
        """Cancel the goal, and return the future state in which that was seen.

        That state is PREEMPTING or RECALLING, or the goal's end.

        :param timeout: longest time until the server accepts that [s]
        :raises ValueError: if the time-out is invalid
        """
        future = GoalFuture(self._client, timeout, "answer to a cancellation")
        with self._lock:
            self._cancels.append(future)
            state, error = self.status, self._error
        if error is not None:
            future.settle(error=error)
        elif state in CANCELING or state in ENDED:
            future.settle(state)
        else:
            self._client.cancel(self.goal_id)
        return future

    def cancel_goal(self, timeout: float = CANCEL_S) -> GoalState:
        """Cancel the goal, and wait until the server accepts that; see :meth:`cancel_goal_async`.

        :param timeout: longest wait [s]
        :raises GoalError: if the server does not, see :meth:`GoalFuture.result`
        """
        state: GoalState = self.cancel_goal_async(timeout).result()
        return state

    # For the client:

    def claim_sending(self) -> bool:
        """Return whether the caller has to send the goal now."""
        with self._lock:
            if self.is_sent or self.answer.done():
                return False
            self.is_sent = True
            return True

    def see(self, state: GoalState, text: str, now: float) -> None:
        """Process the state in which the server lists the goal.

        :param state: the state
        :param text: the server's comment on it
        :param now: monotonic time [s]
        """
        with self._lock:
            self._is_listed, self._missing = True, 0
            if self.status in ENDED:
                return
            self.status, self.text = state, text
            if state in ENDED:
                self.ended_at = now
        self._settle_early()

    def is_missing(self) -> bool:
        """Return whether the goal is lost because the server does not list it."""
        with self._lock:
            self._missing += self._is_listed
            return self._missing >= _MISSING_LISTS and self.ended_at is None

    def end(self, result: GoalResult) -> None:
        """Set the result.

        :param result: the goal's end
        """
        with self._lock:
            self.status, self.text, self._end = result.status, result.text, result
            results, self._results = self._results, []
        self.answer.settle(self)
        self._settle_early()
        for future in results:
            future.settle(result)

    def fail(self, error: Exception) -> None:
        """Set the error of all answers that are missing, unless there is a result.

        :param error: the error
        """
        with self._lock:
            if self._end is not None:
                return
            self._error, self.status = error, GoalState.LOST
            futures = [self.answer, *self._results, *self._cancels]
            self._results, self._cancels = [], []
        for future in futures:
            future.settle(error=error)

    def expire(self, now: float) -> bool:
        """End the waits whose deadline has passed; return whether the server has not answered.

        :param now: monotonic time [s]
        """
        with self._lock:
            waits = [*self._results, *self._cancels]
        for future in waits:
            future.expire(now)
        with self._lock:
            self._results = [one for one in self._results if not one.done()]
            self._cancels = [one for one in self._cancels if not one.done()]
        return self.answer.expire(now)

    def _settle_early(self) -> None:
        """Settle the futures that the present state answers."""
        with self._lock:
            state, cancels = self.status, []
            if state in CANCELING or state in ENDED:
                cancels, self._cancels = self._cancels, []
        if self.accepted:
            self.answer.settle(self)
        for future in cancels:
            future.settle(state)
