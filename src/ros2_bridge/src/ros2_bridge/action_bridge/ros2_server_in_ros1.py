"""ROS 2 action server, offered in ROS 1."""

import collections
import contextlib
import itertools
import threading
import time
from functools import partial
from typing import Any, Callable, Deque, List, Optional, Sequence, Set

import rospy
from action_msgs.msg import GoalInfo
from action_msgs.msg import GoalStatusArray as GoalStatusArray2
from action_msgs.srv import CancelGoal
from rclpy.serialization import deserialize_message, serialize_message
from unique_identifier_msgs.msg import UUID

from nodekit import Node, ReentrantCallbackGroup, Throttle
from ros2_bridge.action_bridge import actionlib_messages
from ros2_bridge.actions.goal_ids import NO_GOAL, text_of
from ros2_bridge.actions.ros2_goal_tracker import Goal, Ros2GoalTracker
from ros2_bridge.actions.states import ROS2_BY_NUMBER, Ros2Status
from ros2_bridge.actions.status_list import read_list
from ros2_bridge.environment.ros1_messages import GoalID, GoalStatusArray
from ros2_bridge.ros2.client import NoResponse, Ros2Client
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.ros2.received_message import ReceivedMessage
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.types.codec import ConversionError
from ros2_bridge.types.type_registry import ActionType

#: Queue size for responses and for feedback.
DEPTH = 1000
#: Rate of the status list [Hz], as in actionlib's server.
_RATE_HZ = 5.0
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 1.0


class Ros2ServerInRos1:
    """ROS 2 action server, offered in ROS 1 once all of its services exist.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the timeout for the server's answer to a goal, and for a result [s]
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        name: str,
        other: str,
        kind: ActionType,
        timeout: Callable[[], float],
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._node, self._participant, self._name, self.kind = node, participant, name, kind
        self._lock = threading.RLock()
        self._goals = Ros2GoalTracker(timeout, self._publish_result, self._publish_status)
        self._numbers = itertools.count(1)
        #: The latest calls of send_goal. Their answers matter even after the timeout: a goal that
        #: is accepted late has to be cancelled.
        self._calls: Deque[int] = collections.deque()
        self._unknown: Set[int] = set()
        self._scope = node.create_scope()
        self._is_offered = False
        impl, path = kind.cls.Impl, f"{other}/_action"
        self._send_type, self._get_type = impl.SendGoalService, impl.GetResultService
        self._send = Ros2Client(participant, self._send_type, f"{path}/send_goal", DEPTH)
        self._get = Ros2Client(participant, self._get_type, f"{path}/get_result", DEPTH)
        self._cancel = Ros2Client(participant, CancelGoal, f"{path}/cancel_goal", DEPTH)
        self._clients = (self._send, self._get, self._cancel)
        self._nothing = kind.result.to_ros1(serialize_message(kind.cls.Result()))
        self._status2 = f"{path}/status"
        quality = QosProfile(1, latched=True)
        self._ends = [
            participant.create_subscription(
                GoalStatusArray2, self._status2, quality, self._on_status
            ),
            participant.create_subscription(
                impl.FeedbackMessage, f"{path}/feedback", QosProfile(DEPTH), self._on_feedback
            ),
        ]

    def follow(self) -> None:
        """Offer the action once the server exists, and end the goals that it has abandoned."""
        now, is_there = time.monotonic(), all(client.is_ready() for client in self._clients)
        if not self._is_offered and is_there and self._senders():
            self._offer()
        with self._lock:
            is_needed = self._goals.is_any_under_way()
        senders = self._senders() if is_needed else set()
        with self._lock:
            self._goals.abort_goals(senders if is_there else set(), now)
            self._goals.remove_old(now)
            waited = self._goals.end_timeouts(now)
            accepted = [(one.uuid, one.is_to_be_cancelled) for one in waited.accepted]
        for uuid, is_cancelled in accepted:
            self._follow_goal(uuid, is_cancelled)
        for goal in waited.without_result:
            rospy.logwarn(
                f"{self._name}: no result of {goal.text} received; the client gets an empty one"
            )

    def _senders(self) -> Set[bytes]:
        """Return the ids of the publishers of the ROS 2 status list."""
        found = self._participant.node.get_publishers_info_by_topic(self._status2)
        return {bytes(one.endpoint_gid) for one in found}

    def _offer(self) -> None:
        name, kind, scope = self._name, self.kind, self._scope
        self._status1 = scope.create_publisher(f"{name}/status", GoalStatusArray, latch=True)
        self._feedback1 = scope.create_publisher(f"{name}/feedback", kind.raw_feedback)
        self._result1 = scope.create_publisher(f"{name}/result", kind.raw_result)
        self._is_offered = True
        group = ReentrantCallbackGroup()
        scope.create_subscription(f"{name}/cancel", GoalID, self._on_cancel, group=group)
        scope.create_subscription(f"{name}/goal", kind.raw_goal, self._on_goal, group=group)
        scope.create_timer(_RATE_HZ, self._list_goals, steady=True, group=group)

    def _on_goal(self, message: Any) -> None:
        try:
            text, stamp, content = actionlib_messages.read_goal(message._buff)
        except ConversionError as error:
            rospy.logwarn(f"{self._name}: a goal from ROS 1 without an id is ignored: {error}")
            return
        began = rospy.Time.now().to_nsec()
        text = text or f"{self._node.name}-{next(self._numbers)}-{began}"
        with self._lock:
            uuid = self._goals.request_goal(text, stamp or began, time.monotonic())
        if uuid is None:
            return
        try:
            goal = deserialize_message(self.kind.goal.to_cdr(content), self.kind.cls.Goal)
            request = self._send_type.Request(goal_id=UUID(uuid=list(uuid)), goal=goal)
            number = self._send.send(request, partial(self._on_goal_response, uuid))
        except (NoResponse, ConversionError) as error:
            with self._lock:
                self._goals.on_goal_response(uuid, False, time.monotonic(), str(error))
            return
        with self._lock:
            self._calls.append(number)
            if len(self._calls) > DEPTH:
                self._send.forget(self._calls.popleft())

    def _on_goal_response(self, uuid: bytes, response: Any) -> None:
        with self._lock:
            is_cancelled = self._goals.on_goal_response(uuid, response.accepted, time.monotonic())
        if response.accepted:
            self._follow_goal(uuid, is_cancelled)

    def _follow_goal(self, uuid: bytes, is_cancelled: bool) -> None:
        """Request the result of an accepted goal.

        :param is_cancelled: whether to cancel it, too
        """
        with contextlib.suppress(NoResponse):  # the server has just ended; a poll will notice
            request = self._get_type.Request(goal_id=UUID(uuid=list(uuid)))
            self._get.send(request, partial(self._on_result, uuid))
        if is_cancelled:
            self._cancel_goal(uuid)

    def _on_result(self, uuid: bytes, response: Any) -> None:
        content = self.kind.result.to_ros1(serialize_message(response.result))
        with self._lock:
            self._goals.on_result(uuid, self._known(response.status), content, time.monotonic())

    def _known(self, number: int) -> Ros2Status:
        """Return the status of a number; UNKNOWN if it is not defined, with a warning."""
        if number not in ROS2_BY_NUMBER and number not in self._unknown:
            self._unknown.add(number)
            rospy.logwarn(f"{self._name}: the server in ROS 2 sends the unknown status {number}")
        return ROS2_BY_NUMBER.get(number, Ros2Status.UNKNOWN)

    def _on_cancel(self, message: Any) -> None:
        until = message.stamp.to_nsec()
        with self._lock:
            goals = self._goals.request_cancel(message.id, until, time.monotonic())
        for uuid in goals:
            self._cancel_goal(uuid)

    def _cancel_goal(self, uuid: bytes) -> None:
        """Ask the server to cancel a goal, or all goals."""

        def check_response(response: Any) -> None:
            if uuid != NO_GOAL and not response.goals_canceling:
                rospy.logwarn(f"{self._name}: the server in ROS 2 does not cancel {text_of(uuid)}")

        info = GoalInfo(goal_id=UUID(uuid=list(uuid)))
        with contextlib.suppress(NoResponse):
            self._cancel.send(CancelGoal.Request(goal_info=info), check_response)

    def _on_status(self, arrived: List[ReceivedMessage]) -> None:
        for one in arrived:
            try:
                goals = read_list(one.data)
            except ValueError as error:
                if self._throttle.is_due("list"):
                    rospy.logwarn(f"{self._name}: invalid list of goals from ROS 2: {error}")
                continue
            # ROS 1 has no negative times.
            listed = [(uuid, max(0, stamp), self._known(status)) for uuid, stamp, status in goals]
            with self._lock:
                cancelled = self._goals.on_status(listed, one.sender, time.monotonic())
            for uuid in cancelled:
                self._cancel_goal(uuid)

    def _on_feedback(self, arrived: List[ReceivedMessage]) -> None:
        for one in arrived:
            with self._lock:
                goal = self._goals.under_way(one.data[4:20])
            if goal is None or not self._is_offered:
                continue
            try:
                content = self.kind.feedback.to_ros1(one.data[:4] + one.data[20:])
            except ConversionError as error:
                if self._throttle.is_due("feedback"):
                    rospy.logwarn(f"{self._name}: feedback to ROS 1: {error}")
                continue
            report = _report(goal, content)
            self._feedback1.publish(actionlib_messages.write_report(self.kind.raw_feedback, report))

    def _publish_result(self, goal: Goal, result: Optional[bytes]) -> None:
        report = _report(goal, self._nothing if result is None else result)
        self._result1.publish(actionlib_messages.write_report(self.kind.raw_result, report))

    def _publish_status(self, goals: Sequence[Goal]) -> None:
        if self._is_offered:
            self._status1.publish(
                actionlib_messages.write_statuses([_report(goal, b"") for goal in goals])
            )

    def _list_goals(self, _: float) -> None:
        with self._lock:
            self._publish_status(self._goals.listed())

    def end_goals(self) -> None:
        """Abort all goals."""
        with self._lock:
            self._goals.abort_goals(set(), time.monotonic())

    def close(self) -> None:
        """Close the server."""
        self.end_goals()
        self._scope.close()
        for end in (*self._ends, *(client.close for client in self._clients)):
            end()


def _report(goal: Goal, content: bytes) -> actionlib_messages.GoalReport:
    return actionlib_messages.GoalReport(goal.text, goal.stamp, goal.status, goal.why, content)
