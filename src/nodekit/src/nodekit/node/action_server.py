"""Server of an action: actionlib's protocol, on a node's publishers and subscriptions."""

import threading
import time
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Set

import rospy
import rospy.core
from actionlib_msgs.msg import GoalID

from nodekit.actions.goal_list import GoalList
from nodekit.actions.goal_states import GoalEvent, GoalState
from nodekit.groups.callback_groups import CallbackGroup, NoGroup
from nodekit.node import fork_guard
from nodekit.node.action_responses import CancelResponse, GoalResponse, is_accepted
from nodekit.node.action_topics import ServerTopics
from nodekit.node.action_types import ActionMessages, GoalError, GoalRejected, check_message
from nodekit.node.callbacks import Callback
from nodekit.node.server_goal_handle import ServerGoalHandle
from nodekit.process_context import PROCESS

#: How often the states of all goals are published, as by actionlib [Hz].
STATUS_HZ = 5.0
#: Most execute callbacks of one server at the same time; further goals are rejected.
MOST_GOALS = 100
#: How long execute callbacks may take to return when their node ends or is deactivated [s].
GRACE_S = 0.5

_NOT_ACTIVE = "the node is not active"
_REPLACED = "another goal was accepted"


class _GoalCallback(Callback):
    """Short callback of an action, in its group."""

    kind = "action"
    takes = 1


class _ExecuteCallback(_GoalCallback):
    """Execute callback, called in its own threads, which no group or executor waits for."""

    kind = "execute"


class ActionServer:
    """Server of one action; :meth:`.NodeScope.create_action_server` returns it.

    :param scope: the scope that owns it
    :param name: name of the action, resolved
    :param messages: message classes of the action
    :param group: group of the short callbacks
    :param execute_callback, goal_callback, handle_accepted_callback, cancel_callback: as there
    :param newest_only: whether an accepted goal replaces the earlier ones
    """

    def __init__(
        self,
        scope: Any,
        name: str,
        messages: ActionMessages,
        group: CallbackGroup,
        execute_callback: Optional[Callable[[ServerGoalHandle], Any]],
        goal_callback: Optional[Callable[[Any], Any]],
        handle_accepted_callback: Optional[Callable[[ServerGoalHandle], Any]],
        cancel_callback: Optional[Callable[[ServerGoalHandle], Any]],
        newest_only: bool,
    ) -> None:
        if execute_callback is None and handle_accepted_callback is None:
            must = "needs an execute_callback or a handle_accepted_callback"
            raise TypeError(f"action {name}: {must}")
        self.name = name
        self._messages, self._group, self._newest_only = messages, group, newest_only
        self._is_active: Callable[[], bool] = scope._is_active
        self._lock = threading.Lock()
        self._left = threading.Condition(self._lock)
        self._goals = GoalList()
        self._handles: Dict[str, ServerGoalHandle] = {}  # of goals that have not ended
        self._waiting: Optional[ServerGoalHandle] = None  # for the end of an earlier goal
        self._threads: Set[int] = set()  # of execute callbacks
        self._is_closed = False

        def own(cls: type, function: Optional[Callable[..., Any]], what: str, group: Any) -> Any:
            if function is None:
                return None
            return scope.own(cls(group, function, f"{name}: {what}"))

        self._execute = own(_ExecuteCallback, execute_callback, "execute_callback", NoGroup())
        self._goal = own(_GoalCallback, goal_callback, "goal_callback", group)
        self._cancel = own(_GoalCallback, cancel_callback, "cancel_callback", group)
        what = "handle_accepted_callback"
        self._accepted = own(_GoalCallback, handle_accepted_callback, what, group)
        self._topics = ServerTopics(scope, name, messages, self._goals)
        scope.own(self)  # after its publishers, so that it is closed before them
        scope.before_deactivate(self._deactivate)
        self._publish_status(0.0)  # latched: clients see that there is a server
        scope.create_timer(STATUS_HZ, self._publish_status, steady=True, group=NoGroup())
        scope.create_subscription(f"{name}/cancel", GoalID, self._on_cancel, group=NoGroup())
        goal = messages.action_goal
        scope.create_subscription(f"{name}/goal", goal, self._on_goal, group=NoGroup())
        PROCESS.by_name(ActionServer)[name] = self

    def __str__(self) -> str:
        return f"action {self.name}"

    def waits_for_caller(self) -> bool:
        """Return whether a goal sent now would wait for the calling thread."""
        deciding = self._goal or self._accepted
        if deciding is None or self._is_closed:
            return False
        calls = deciding.calls
        is_its_thread = calls is not None and calls.ready.is_served_by_caller_alone()
        return bool(self._group.is_mine or is_its_thread)

    def _deactivate(self) -> None:
        self._end_all("the node ends" if rospy.core.is_shutdown_requested() else _NOT_ACTIVE)

    def close(self) -> None:
        """Abort all goals, and accept no others."""
        self._is_closed = True
        self._end_all("the server was closed")

    # Requests of clients:

    def _on_goal(self, message: Any) -> None:
        ros_time, now = rospy.Time.now().to_nsec(), time.monotonic()
        id = message.goal_id.id or f"{self.name}-{PROCESS.next_number(ActionServer)}-{ros_time}"
        with self._lock:
            arrival = self._goals.add(id, message.goal_id.stamp.to_nsec(), ros_time, now)
            handle = ServerGoalHandle(self, arrival.goal, message.goal)
            if arrival.is_new:
                self._handles[id] = handle
            elif arrival.is_recalled:
                self._topics.queue_result(arrival.goal, self._messages.result())
        if arrival.is_recalled:
            self._topics.send()
        if arrival.is_new:
            deciding = self._goal or self._accepted
            if deciding is None:
                self._decide(handle)
            else:
                deciding.offer(partial(self._decide, handle))

    def _on_cancel(self, message: GoalID) -> None:
        stamp, ros_time = message.stamp.to_nsec(), rospy.Time.now().to_nsec()
        asked: List[ServerGoalHandle] = []
        with self._lock:
            for goal in self._goals.cancel(message.id, stamp, ros_time, time.monotonic()):
                handle = self._handles[goal.id]
                if goal.state is GoalState.PENDING:
                    self._apply(handle, GoalEvent.CANCEL, "cancelled")
                elif self._cancel is None:
                    self._apply(handle, GoalEvent.REQUEST_CANCEL, goal.text)
                else:
                    asked.append(handle)
        self._topics.send()
        for handle in asked:
            self._cancel.offer(partial(self._decide_cancel, handle))

    # Decisions, inside the group unless there is no callback to call:

    def _decide(self, handle: ServerGoalHandle) -> None:
        """Accept a goal and have it executed, or reject it."""
        if not self._takes_goals():
            self._abort_unaccepted(handle)
            return
        reason = self._reason_to_reject(handle.request)
        if reason is not None:
            self._end(handle, GoalEvent.REJECT, None, reason)
            return
        with self._lock:
            if handle.goal.has_ended:  # it was cancelled meanwhile
                return
            executes = self._accepted is None
            if self._newest_only:
                self._replace_others(handle)
            if self._newest_only and executes and self._threads:
                self._waiting = handle
                may_begin = False
            else:
                may_begin = self._accept(handle, executes)
        self._topics.send()
        if may_begin and executes:
            self._start_thread(handle)
        elif may_begin:
            self._call_accepted(handle)

    def _accept(self, handle: ServerGoalHandle, executes: bool) -> bool:
        """Accept a goal, and reserve a thread for it; return whether its state allows that."""
        is_accepted = self._apply(handle, GoalEvent.ACCEPT, "")
        if is_accepted and executes:
            self._reserve_thread(handle)
        return is_accepted

    def _takes_goals(self) -> bool:
        is_ending = self._is_closed or rospy.core.is_shutdown_requested()
        return self._is_active() and not is_ending

    def _reason_to_reject(self, request: Any) -> Optional[str]:
        """Return why a goal is rejected; None if it is accepted."""
        if self._accepted is None and len(self._threads) >= MOST_GOALS:
            return f"{MOST_GOALS} goals are running already"
        if self._goal is None:
            return None
        try:
            if is_accepted(fork_guard.call(self._goal.function, request), GoalResponse):
                return None
            return "rejected"
        except GoalRejected as reason:
            return str(reason)
        except BaseException as error:
            self._goal.errors.record(self._goal.what, self._goal.closed)
            return f"{type(error).__name__}: {error}"

    def _replace_others(self, handle: ServerGoalHandle) -> None:
        """End the earlier goals, or request their end if execute callbacks run."""
        for other in list(self._handles.values()):
            if other is handle:
                continue
            if other is self._waiting or not other.executing_thread:
                if other is self._waiting or other.is_active:
                    other.is_ended_by_server = True
                    self._apply(other, GoalEvent.CANCEL, _REPLACED)
            else:
                self._apply(other, GoalEvent.REQUEST_CANCEL, _REPLACED)

    def _call_accepted(self, handle: ServerGoalHandle) -> None:
        try:
            fork_guard.call(self._accepted.function, handle)
        except BaseException as error:
            self._accepted.errors.record(self._accepted.what, self._accepted.closed)
            self._end(handle, GoalEvent.ABORT, None, f"{type(error).__name__}: {error}")

    def _decide_cancel(self, handle: ServerGoalHandle) -> None:
        """Request the end of a goal, unless the cancel callback rejects that."""
        if not handle.is_active or self._cancel.closed:
            return
        try:
            if not is_accepted(fork_guard.call(self._cancel.function, handle), CancelResponse):
                return
        except BaseException:  # the goal is cancelled all the same: the client wants it to end
            self._cancel.errors.record(self._cancel.what, self._cancel.closed)
        with self._lock:
            self._apply(handle, GoalEvent.REQUEST_CANCEL, handle.goal.text)
        self._topics.send()

    # Execution:

    def execute(self, handle: ServerGoalHandle) -> None:
        """Call the execute callback in a thread; see :meth:`.ServerGoalHandle.execute`."""
        if self._execute is None or handle.executing_thread or not handle.is_active:
            why = "there is no execute_callback" if self._execute is None else "not a second time"
            raise GoalError(f"{self}: goal {handle.goal_id} is not executed: {why}")
        with self._lock:
            self._reserve_thread(handle)
        self._start_thread(handle)

    def _reserve_thread(self, handle: ServerGoalHandle) -> None:
        handle.executing_thread = -1  # until it has an id
        self._threads.add(id(handle))

    def _start_thread(self, handle: ServerGoalHandle) -> None:
        threading.Thread(
            target=self._run, args=(handle,), name=f"goal of {self.name}", daemon=True
        ).start()

    def _run(self, handle: ServerGoalHandle) -> None:
        handle.executing_thread = threading.get_ident()
        execute = self._execute
        execute.group.enter()
        try:
            self._call_execute(handle)
        finally:
            handle.executing_thread = -1
            execute.group.leave()
            following: Optional[ServerGoalHandle] = None
            with self._lock:
                self._threads.discard(id(handle))
                self._left.notify_all()
                if not self._threads and self._waiting is not None:
                    waiting, self._waiting = self._waiting, None
                    following = waiting if self._accept(waiting, True) else None
            self._topics.send()
            if following is not None:
                self._start_thread(following)

    def _call_execute(self, handle: ServerGoalHandle) -> None:
        execute = self._execute
        try:
            result = None
            if handle.is_active and not execute.closed:
                result = fork_guard.call(execute.function, handle)
            if result is not None:
                check_message(result, self._messages.result, f"{execute.what}: result")
        except BaseException as error:  # SystemExit too: the client would wait for its result
            execute.errors.record(execute.what, execute.closed)
            self._end(handle, GoalEvent.ABORT, None, f"{type(error).__name__}: {error}")
            return
        if handle.outcome is None and handle.is_active:
            text = "its execute callback has returned without succeed(), abort() or canceled()"
            rospy.logwarn("%s: goal %s is aborted: %s", self, handle.goal_id, text)
            handle.outcome = (GoalEvent.ABORT, text)
        if handle.outcome is not None:
            self._end(handle, handle.outcome[0], result, handle.outcome[1])

    # Ends of goals:

    def end(self, handle: ServerGoalHandle, event: GoalEvent, result: Any, text: str) -> None:
        """End a goal at its callback's request; see :meth:`.ServerGoalHandle.succeed`."""
        if result is not None:
            check_message(result, self._messages.result, f"{self}: result")
        elif handle.executing_thread == threading.get_ident() and handle.outcome is None:
            if handle.is_active:
                handle.outcome = (event, text)
                return
        if handle.outcome is not None or not self._end(handle, event, result, text):
            self._check_not_ended(handle, event.value)

    def publish_feedback(self, handle: ServerGoalHandle, feedback: Any) -> None:
        """Send feedback of a goal; see :meth:`.ServerGoalHandle.publish_feedback`."""
        check_message(feedback, self._messages.feedback, f"{self}: feedback")
        if not handle.is_active:
            self._check_not_ended(handle, "publish_feedback")
            return
        self._topics.publish_feedback(handle.goal, feedback)

    def _check_not_ended(self, handle: ServerGoalHandle, what: str) -> None:
        if not handle.is_ended_by_server:
            state = (handle.outcome[0] if handle.outcome else handle.status).name
            raise GoalError(f"{self}: {what}: goal {handle.goal_id} has ended before: {state}")

    def _end(self, handle: ServerGoalHandle, event: GoalEvent, result: Any, text: str) -> bool:
        """End a goal, and send its result; return whether that is allowed in its state."""
        with self._lock:
            has_ended = self._apply(handle, event, text, result)
        self._topics.send()
        return has_ended

    def _abort_unaccepted(self, handle: ServerGoalHandle) -> None:
        """Abort a goal that arrives while the node is not active."""
        with self._lock:
            handle.is_ended_by_server = True
            self._apply(handle, GoalEvent.ACCEPT, "")
            self._apply(handle, GoalEvent.ABORT, _NOT_ACTIVE)
        self._topics.send()

    def _end_all(self, why: str) -> None:
        """Request the end of all goals, and abort those that do not end in time."""
        with self._lock:
            self._waiting = None
            for handle in list(self._handles.values()):
                if handle.executing_thread:
                    self._apply(handle, GoalEvent.REQUEST_CANCEL, why)
        self._topics.send()
        me = threading.get_ident()
        with self._left:
            if not any(one.executing_thread == me for one in self._handles.values()):
                self._left.wait_for(lambda: not self._threads, GRACE_S)
            for handle in list(self._handles.values()):
                handle.is_ended_by_server = True
                self._apply(handle, GoalEvent.ACCEPT, "")  # of a goal that is still pending
                self._apply(handle, GoalEvent.ABORT, why)
        self._topics.send()

    def _apply(
        self, handle: ServerGoalHandle, event: GoalEvent, text: str, result: Any = None
    ) -> bool:
        """Change a goal's state, and queue its messages; return whether it is allowed.

        Called with the lock, so that messages are queued in the order of the changes.
        """
        goal = handle.goal
        if not self._goals.apply(goal, event, text, time.monotonic()):
            return False
        if goal.has_ended:
            self._handles.pop(goal.id, None)
            self._topics.queue_result(goal, self._messages.result() if result is None else result)
        else:
            self._topics.queue_status()
        return True

    def _publish_status(self, _elapsed: float) -> None:
        with self._lock:
            self._goals.drop_ended(time.monotonic())
            self._topics.queue_status()
        self._topics.send()
