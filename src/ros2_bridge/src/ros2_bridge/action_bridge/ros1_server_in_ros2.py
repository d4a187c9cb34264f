"""ROS 1 action server, offered in ROS 2."""

import contextlib
import threading
import time
from typing import Any, Callable, List, Optional, Sequence, Set

import rospy
from action_msgs.msg import GoalInfo
from action_msgs.msg import GoalStatusArray as GoalStatusArray2
from builtin_interfaces.msg import Time
from rclpy.node import Node as Ros2Node
from rclpy.serialization import deserialize_message, serialize_message
from unique_identifier_msgs.msg import UUID

from nodekit import Node, ReentrantCallbackGroup, Throttle
from ros2_bridge.action_bridge import actionlib_messages
from ros2_bridge.actions.goal_ids import bytes_of
from ros2_bridge.actions.ros1_goal_tracker import Goal, Ros1GoalTracker
from ros2_bridge.actions.states import ROS1_BY_NUMBER, ROS1_TERMINAL, Ros1Status, Ros2Status
from ros2_bridge.actions.status_list import ListedGoal, seconds_of, write_list
from ros2_bridge.environment.ros1_messages import GoalID, GoalStatusArray
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.types.codec import ConversionError
from ros2_bridge.types.type_registry import ActionType

#: Queue size for requests and for feedback.
DEPTH = 1000
#: A server that has been disconnected for this long has lost its goals [s].
_GONE_S = 1.0
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 1.0


class Ros1ServerInRos2:
    """ROS 1 action server, offered in ROS 2 once all of its topics are connected.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param owner: ROS 2 node that offers it
    :param name, other: its name in ROS 1 and in ROS 2
    :param timeout: returns the timeout for the server's reaction to a goal or a cancellation [s]
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        owner: Ros2Node,
        name: str,
        other: str,
        kind: ActionType,
        timeout: Callable[[], float],
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._participant, self.owner, self._name, self._other = participant, owner, name, other
        self.kind = kind
        self._lock = threading.RLock()
        self._goals = Ros1GoalTracker(timeout, self._publish_status)
        self._offered: Optional[contextlib.ExitStack] = None
        self._connected = time.monotonic()
        self._unknown: Set[int] = set()
        self._scope = scope = node.create_scope()
        group = ReentrantCallbackGroup()
        self._goal = scope.create_publisher(f"{name}/goal", kind.raw_goal)
        self._cancel = scope.create_publisher(f"{name}/cancel", GoalID)
        self._links: List[Any] = [
            self._goal,
            self._cancel,
            scope.create_subscription(
                f"{name}/status", GoalStatusArray, self._on_status, group=group
            ),
            scope.create_subscription(
                f"{name}/feedback", kind.raw_feedback, self._on_feedback, group=group
            ),
            scope.create_subscription(
                f"{name}/result", kind.raw_result, self._on_result, group=group
            ),
        ]

    def follow(self) -> None:
        """Offer the action once the server is connected, and handle timeouts."""
        now, is_connected = time.monotonic(), self._is_connected()
        if is_connected:
            self._connected = now
            if self._offered is None:
                self._offer()
        with self._lock:
            if now > self._connected + _GONE_S:
                self._goals.abort_all(now)
            given_up = self._goals.end_timeouts(now)
        for text in given_up.without_result:
            rospy.logwarn(
                f"{self._name}: no result of {text} received; the client gets an empty one"
            )
        for text in given_up.unheard:
            rospy.logwarn(f"{self._name}: no status of a goal from ROS 2 received; it is rejected")
            self._cancel.publish(actionlib_messages.goal_id(text, 0))

    def _is_connected(self) -> bool:
        return all(link.get_num_connections() for link in self._links)

    def _offer(self) -> None:
        participant, owner, impl = self._participant, self.owner, self.kind.cls.Impl
        path, quality = f"{self._other}/_action", QosProfile(1, latched=True)
        with contextlib.ExitStack() as ends:  # all, or nothing
            self._status2 = participant.create_publisher(
                owner, GoalStatusArray2, f"{path}/status", quality
            )
            ends.callback(participant.destroy_publisher, owner, self._status2)
            self._feedback2 = participant.create_publisher(
                owner, impl.FeedbackMessage, f"{path}/feedback", QosProfile(DEPTH)
            )
            ends.callback(participant.destroy_publisher, owner, self._feedback2)
            for cls, name, answer in (
                (impl.CancelGoalService, "cancel_goal", self._answer_cancel),
                (impl.GetResultService, "get_result", self._answer_result),
                (impl.SendGoalService, "send_goal", self._answer_goal),
            ):
                ends.callback(
                    participant.create_service(owner, cls, f"{path}/{name}", answer, DEPTH)
                )
            self._offered = ends.pop_all()
        with self._lock:
            self._goals.publish_all()

    def _answer_goal(self, request: Any, send: Callable[[Any], None]) -> None:
        stamp = rospy.Time.now().to_nsec()

        def answer(is_accepted: bool) -> None:
            response = self.kind.cls.Impl.SendGoalService.Response(accepted=is_accepted)
            response.stamp = _time(stamp)
            send(response)

        if not self._is_connected():
            rospy.logwarn(f"{self._name} is not connected: a goal from ROS 2 is rejected")
            answer(False)
            return
        try:
            content = self.kind.goal.to_ros1(serialize_message(request.goal))
        except ConversionError as error:
            rospy.logwarn(f"{self._name}: a goal from ROS 2 is rejected: {error}")
            answer(False)
            return
        uuid = bytes(request.goal_id.uuid)
        with self._lock:
            text = self._goals.request_goal(uuid, stamp, time.monotonic(), answer)
        if text:
            self._goal.publish(
                actionlib_messages.write_goal(self.kind.raw_goal, text, stamp, content)
            )

    def _answer_result(self, request: Any, send: Callable[[Any], None]) -> None:
        def answer(status: Ros2Status, content: bytes) -> None:
            response = self.kind.cls.Impl.GetResultService.Response(status=int(status))
            if content:
                cdr = self.kind.result.to_cdr(content)
                response.result = deserialize_message(cdr, self.kind.cls.Result)
            send(response)

        with self._lock:
            self._goals.request_result(bytes(request.goal_id.uuid), answer)

    def _answer_cancel(self, request: Any, send: Callable[[Any], None]) -> None:
        def answer(code: int, goals: Sequence[Goal]) -> None:
            response = self.kind.cls.Impl.CancelGoalService.Response(return_code=code)
            response.goals_canceling = [_info(goal) for goal in goals]
            send(response)

        asked = request.goal_info
        uuid, until = bytes(asked.goal_id.uuid), asked.stamp.sec * 10**9 + asked.stamp.nanosec
        if until:
            # Not in the future: actionlib would also recall later goals that begin before. Not 0,
            # which means all goals; 1 matches none, because ROS 1 has no negative times.
            until = max(1, min(until, rospy.Time.now().to_nsec()))
        with self._lock:
            text = self._goals.request_cancel(uuid, until, time.monotonic(), answer)
        if text is not None:
            self._cancel.publish(actionlib_messages.goal_id(text, until))

    def _on_status(self, message: Any) -> None:
        listed = [
            (text, stamp, self._known(text, number))
            for text, stamp, number in actionlib_messages.read_statuses(message)
        ]
        with self._lock:
            self._goals.on_status(listed, time.monotonic())

    def _known(self, text: str, number: int) -> Optional[Ros1Status]:
        """Return the status of a number; None if it is unknown, with a warning."""
        if number not in ROS1_BY_NUMBER and number not in self._unknown:
            self._unknown.add(number)
            rospy.logwarn(f"{self._name} lists {text} with the unknown status {number}")
        return ROS1_BY_NUMBER.get(number)

    def _on_result(self, message: Any) -> None:
        try:
            report = actionlib_messages.read_report(message._buff)
        except ConversionError as error:
            rospy.logwarn(f"{self._name}: a result without a valid goal is ignored: {error}")
            return
        status, content = ROS1_BY_NUMBER.get(report.status), report.content
        try:
            self.kind.result.to_cdr(content)
            if status not in ROS1_TERMINAL:
                raise ConversionError(f"status {report.status} is not final")
        except ConversionError as error:
            rospy.logwarn(f"{self._name}: {report.text} is aborted, invalid result: {error}")
            status, content = Ros1Status.LOST, b""
        with self._lock:
            self._goals.on_result(report.text, report.stamp, status, content, time.monotonic())

    def _on_feedback(self, message: Any) -> None:
        if self._offered is None:
            return
        try:
            report = actionlib_messages.read_report(message._buff)
            cdr = self.kind.feedback.to_cdr(report.content)
        except ConversionError as error:
            if self._throttle.is_due():
                rospy.logwarn(f"{self._name}: feedback to ROS 2: {error}")
            return
        # The 16-byte id does not change the alignment of the fields behind it.
        self._feedback2.publish(cdr[:4] + bytes_of(report.text) + cdr[4:])

    def _publish_status(self, goals: Sequence[Goal]) -> None:
        if self._offered is not None:
            listed = (ListedGoal(goal.uuid, goal.stamp, goal.status or 0) for goal in goals)
            self._status2.publish(write_list(listed))

    def end_goals(self) -> None:
        """Abort all goals."""
        with self._lock:
            self._goals.abort_all(time.monotonic())

    def close(self) -> None:
        """Close the server."""
        self.end_goals()
        with self._lock:
            offered, self._offered = self._offered, None
        self._scope.close()
        if offered is not None:
            offered.close()


def _time(stamp: int) -> Any:
    seconds, rest = seconds_of(stamp)  # which ROS 1's clients set
    return Time(sec=seconds, nanosec=rest)


def _info(goal: Goal) -> Any:
    return GoalInfo(goal_id=UUID(uuid=list(goal.uuid)), stamp=_time(goal.stamp))
