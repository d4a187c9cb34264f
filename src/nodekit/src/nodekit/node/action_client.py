"""Client of an action: actionlib's protocol, with time-outs, and without deadlocks."""

import math
import threading
import time
import uuid
from functools import partial
from typing import Any, Callable, Dict, Optional

import rospy
from actionlib_msgs.msg import GoalID, GoalStatusArray

from nodekit.actions.goal_states import GoalState
from nodekit.argument_checks import check_function, check_timeout, check_wait
from nodekit.groups.callback_groups import CallbackGroup, NoGroup
from nodekit.node.action_server import ActionServer
from nodekit.node.action_types import (
    ActionMessages,
    GoalError,
    GoalLost,
    GoalTimeout,
    check_message,
    header_now,
)
from nodekit.node.callbacks import Callback
from nodekit.node.client_goal_handle import ClientGoalHandle, GoalFuture, GoalResult
from nodekit.process_context import PROCESS

#: Default time-out of an immediate answer of a server [s].
ANSWER_S = 5.0
#: How often deadlines and the server are checked while goals are running [Hz].
_CHECK_HZ = 20.0
#: How long a server may be disconnected before its goals are lost [s].
_GONE_S = 1.0
#: How long a result may take after the goal is listed as ended [s].
_RESULT_S = 2.0
#: Shortest wait for a result after the goal's acceptance [s].
_SHORTEST_S = 0.001
#: Least time between two log lines about a missing server [s].
_LOG_EVERY_S = 1.0


class ActionClient:
    """Client of one action; :meth:`.NodeScope.create_action_client` returns it.

    :param scope: the scope that owns it
    :param name: name of the action, resolved
    :param messages: message classes of the action
    :param group: group of feedback and done callbacks
    """

    def __init__(
        self, scope: Any, name: str, messages: ActionMessages, group: CallbackGroup
    ) -> None:
        self.name = name
        self._messages = messages
        self._node = scope.name
        self._lock = threading.Lock()
        self._goals: Dict[str, ClientGoalHandle] = {}  # that have not ended
        self._server = ""  # name of the node that sent the latest states
        self._connected_at = time.monotonic()
        self._is_closed = False
        #: Calls feedback and done callbacks, in the group.
        self.done: Callback = scope.own(
            Callback(group, lambda function, thing: function(thing), f"action {name}")
        )
        self._goal = scope._publish(f"{name}/goal", messages.action_goal, queue_size=0)
        self._cancel = scope._publish(f"{name}/cancel", GoalID, queue_size=0)
        self._timer = scope.create_timer(0.0, self._check, steady=True, group=NoGroup())
        subscribe = partial(scope.create_subscription, group=NoGroup())
        self._sources = [
            subscribe(f"{name}/result", messages.action_result, self._on_result),
            subscribe(f"{name}/feedback", messages.action_feedback, self._on_feedback),
            subscribe(f"{name}/status", GoalStatusArray, self._on_status),
        ]
        scope.own(self)

    def __str__(self) -> str:
        return f"action {self.name}"

    def server_is_ready(self) -> bool:
        """Return whether a server is connected by all topics."""
        server = self._server
        return bool(server) and all(
            server in names
            for names in (
                self._goal.subscribers(),
                self._cancel.subscribers(),
                *(source.publishers() for source in self._sources),
            )
        )

    def wait_for_server(self, timeout: float = math.inf) -> bool:
        """Wait until a server is ready; log each second that it is not.

        :param timeout: longest wait [s]; by default until the node ends
        :returns: whether it is ready
        :raises ValueError: if the time-out is not a number
        """
        check_wait(timeout)
        began = logged = time.monotonic()
        while not (self._is_closed or rospy.is_shutdown()):
            if self.server_is_ready():
                return True
            if time.monotonic() >= logged + _LOG_EVERY_S:
                logged = time.monotonic()
                rospy.loginfo("%s is not available, waiting again...", self)
            left = began + timeout - time.monotonic()
            if left <= 0.0:
                break
            time.sleep(min(1.0 / _CHECK_HZ, left))
        return False

    def send_goal(
        self,
        goal: Any,
        timeout: float,
        feedback_callback: Optional[Callable[[Any], Any]] = None,
    ) -> GoalResult:
        """Send a goal, and wait for its result; cancel it after the timeout.

        :param goal: of the action's goal class
        :param timeout: longest time to the result [s]
        :param feedback_callback: called with each feedback that arrives before the result
        :returns: the goal's end
        :raises GoalTimeout: if there is no server, or no result in time
        :raises GoalError: if the server has gone, or waits for the calling thread
        """
        self.reject_nested()
        check_timeout(timeout)
        deadline = time.monotonic() + timeout
        handle: ClientGoalHandle = self.send_goal_async(goal, feedback_callback, timeout).result()
        try:
            return handle.get_result(max(_SHORTEST_S, deadline - time.monotonic()))
        except GoalTimeout:
            self.cancel(handle.goal_id)
            why = f"no result within {timeout:g} s: the goal is cancelled"
            raise GoalTimeout(f"{self}: {why}") from None

    def send_goal_async(
        self,
        goal: Any,
        feedback_callback: Optional[Callable[[Any], Any]] = None,
        timeout: float = ANSWER_S,
    ) -> GoalFuture:
        """Send a goal without waiting; it is sent as soon as a server is ready.

        :param goal: of the action's goal class
        :param feedback_callback: called with each feedback that arrives before the result
        :param timeout: longest time until the server has accepted or rejected it [s]; it is
            cancelled then
        :returns: the future :class:`.ClientGoalHandle`
        :raises TypeError: if the goal is of another class, or the value of a field does not fit
        :raises ValueError: if the time-out is invalid
        :raises GoalError: if the client is closed
        """
        check_timeout(timeout)
        check_message(goal, self._messages.goal, f"{self}: goal")
        if feedback_callback is not None:
            check_function(feedback_callback, f"{self}: feedback_callback", 1)
        if self._is_closed or rospy.is_shutdown():
            raise GoalError(f"{self}: no goal is sent: its client is closed")
        id = f"{self._node}-{PROCESS.next_number(ActionClient)}-{uuid.uuid4().hex[:12]}"
        handle = ClientGoalHandle(self, id, goal, feedback_callback, timeout)
        with self._lock:
            self._goals[id] = handle
        self._timer.set_rate(_CHECK_HZ)  # calls immediately, which sends the goal
        return handle.answer

    def cancel(self, id: str = "", stamp: Optional[rospy.Time] = None) -> None:
        """Cancel goals, of other clients too, without waiting.

        :param id: id of a goal; empty for all goals, or those until the stamp
        :param stamp: cancel all goals that were sent until then
        """
        self._cancel.publish(GoalID(stamp or rospy.Time(), id))

    def close(self) -> None:
        """Cancel the running goals, and send no others."""
        self._is_closed = True
        with self._lock:
            goals, self._goals = list(self._goals.values()), {}
        for handle in goals:
            if handle.is_sent:
                self.cancel(handle.goal_id)
            handle.fail(GoalError(f"{self}: the client was closed"))

    def reject_nested(self) -> None:
        """Reject a wait for a server of this process that waits for the calling thread.

        :raises GoalError: if it does
        """
        server = PROCESS.by_name(ActionServer).get(self.name)
        if server is not None and server.waits_for_caller():
            raise GoalError(
                f"{self}: its server decides in the callback group or by the thread that would"
                " wait for it; give the server its own group, or use send_goal_async"
            )

    # Messages of the server:

    def _on_status(self, message: GoalStatusArray) -> None:
        self._server = str(message._connection_header.get("callerid", ""))
        listed = {status.goal_id.id: status for status in message.status_list}
        now = time.monotonic()
        with self._lock:
            goals = list(self._goals.values())
        for handle in goals:
            status = listed.get(handle.goal_id)
            if status is not None:
                handle.see(GoalState(status.status), status.text, now)
            elif handle.is_missing():
                self._lose(handle, "the server does not list it any longer")

    def _on_result(self, message: Any) -> None:
        with self._lock:
            handle = self._goals.pop(message.status.goal_id.id, None)
        if handle is not None:
            status = message.status
            handle.end(GoalResult(GoalState(status.status), status.text, message.result))

    def _on_feedback(self, message: Any) -> None:
        with self._lock:
            handle = self._goals.get(message.status.goal_id.id)
        if handle is None:
            return
        handle.see(GoalState(message.status.status), message.status.text, time.monotonic())
        if handle.feedback_callback is not None:
            self.offer(handle.feedback_callback, message.feedback)

    def offer(self, function: Callable[[Any], Any], thing: Any) -> None:
        """Call a function of the user in the group, without waiting.

        :param function: the function
        :param thing: its argument
        """
        self.done.offer(partial(self.done.call_inside, function, thing))

    # Deadlines, and goals whose server has gone:

    def _check(self, _elapsed: float) -> None:
        now = time.monotonic()
        is_ready = self.server_is_ready()
        if is_ready or not self._server:
            self._connected_at = now
        with self._lock:
            goals = list(self._goals.values())
        for handle in goals:
            if is_ready and handle.claim_sending():
                stamp = GoalID(rospy.Time.now(), handle.goal_id)
                self._goal.publish(self._messages.action_goal(header_now(), stamp, handle.goal))
            elif handle.is_sent and now > self._connected_at + _GONE_S:
                self._lose(handle, "the server has gone")
            elif handle.ended_at is not None and now > handle.ended_at + _RESULT_S:
                self._lose(handle, f"it is {handle.status.name}, but its result was lost")
            if handle.expire(now):
                self._forget(handle)
        with self._lock:
            if not self._goals:
                self._timer.set_rate(0.0)

    def _forget(self, handle: ClientGoalHandle) -> None:
        """Stop following an unanswered goal; cancel it if it was sent."""
        with self._lock:
            self._goals.pop(handle.goal_id, None)
        if handle.is_sent:
            self.cancel(handle.goal_id)

    def _lose(self, handle: ClientGoalHandle, why: str) -> None:
        with self._lock:
            self._goals.pop(handle.goal_id, None)
        handle.fail(GoalLost(f"{self}: goal {handle.goal_id} is lost: {why}"))
