"""Servers with undefined statuses, and malformed messages."""

import itertools
import struct
import threading
import time
from types import SimpleNamespace
from typing import Any, Iterator, List

import both
import pytest
import rospy
from action_msgs.msg import GoalInfo
from action_msgs.msg import GoalStatus as Ros2Status
from action_msgs.msg import GoalStatusArray as Statuses2
from action_msgs.srv import CancelGoal
from action_parts import Client1, Client2, cancel
from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from bot_controller_demo_msgs.action import GoTo
from nodekit import Throttle
from nodekit.testing.waiting import wait_until
from ros2_bridge.action_bridge import actionlib_messages
from ros2_bridge.action_bridge.ros1_server_in_ros2 import Ros1ServerInRos2
from ros2_bridge.action_bridge.ros2_server_in_ros1 import Ros2ServerInRos1
from ros2_bridge.actions.goal_ids import text_of
from ros2_bridge.actions.ros2_goal_tracker import NO_END, NO_RESULT, Goal
from ros2_bridge.actions.states import Ros1Status
from ros2_bridge.actions.status_list import ListedGoal, write_list
from ros2_bridge.environment.ros1_messages import GoalID, GoalStatusArray
from ros2_bridge.types.codec_ops import ConversionError

_UNKNOWN = 42
#: Later than ROS 2's time [s].
_LATE_S = 2**32 - 1


class Server1:
    """A ROS 1 server that publishes any status of a received goal on request."""

    def __init__(self, ros: both.Both, name: str) -> None:
        kind = self._kind = ros.types.action("bot_controller_demo_msgs/GoTo")
        self._goals: List[Any] = []
        self._status = rospy.Publisher(f"{name}/status", GoalStatusArray, queue_size=10, latch=True)
        self._feedback = rospy.Publisher(f"{name}/feedback", kind.raw_feedback, queue_size=10)
        self._result = rospy.Publisher(f"{name}/result", kind.raw_result, queue_size=10)
        rospy.Subscriber(f"{name}/goal", kind.raw_goal, self._goals.append)
        rospy.Subscriber(f"{name}/cancel", GoalID, lambda message: None)
        made = GoTo.Result()
        made.progress.phase = "odd"
        self.content = kind.result.to_ros1(serialize_message(made))

    def forget(self) -> None:
        self._goals.clear()

    def _report(self, status: int, content: bytes) -> actionlib_messages.GoalReport:
        wait_until(lambda: self._goals, lambda: "no goal")
        text, stamp, _ = actionlib_messages.read_goal(self._goals[-1]._buff)
        return actionlib_messages.GoalReport(text, stamp, status, "why", content)

    def list_goal(self, status: int, stamp: int = 0) -> None:
        """List the goal, and another client's, if its start time [ns] is given."""
        listed = [self._report(status, b"")]
        if stamp:
            listed.append(
                actionlib_messages.GoalReport("theirs", stamp, Ros1Status.ACTIVE, "", b"")
            )
        self._status.publish(actionlib_messages.write_statuses(listed))

    def feed(self, status: int, cut: int = 0) -> None:
        """Publish feedback, some bytes too short."""
        content = self.content[: len(self.content) - cut]
        message = actionlib_messages.write_report(
            self._kind.raw_feedback, self._report(status, content)
        )
        self._feedback.publish(message)

    def end(self, status: int, cut: int = 0, why: bytes = b"why") -> None:
        """Publish a result, some bytes too short, with a text of as many bytes as "why"."""
        content = self.content[: len(self.content) - cut]
        message = actionlib_messages.write_report(
            self._kind.raw_result, self._report(status, content)
        )
        message._buff = message._buff.replace(b"why", why)
        self._result.publish(message)

    def publish_nonsense(self) -> None:
        """Publish a malformed result."""
        message = self._kind.raw_result()
        message._buff = b"nonsense" * 2
        self._result.publish(message)


@pytest.fixture(scope="module")
def made1(ros: both.Both, bridge: both.Bridge) -> Server1:
    return Server1(ros, "/odd/arm")


@pytest.fixture
def server1(made1: Server1) -> Server1:
    made1.forget()
    return made1


@pytest.fixture(scope="module")
def client2(ros: both.Both, made1: Server1) -> Iterator[Client2]:
    made = Client2(ros, "/odd/arm")
    yield made
    made.close()


def begin(server1: Server1, client2: Client2, key: str) -> None:
    """Send a goal that the server accepts."""
    client2.send(key, 1.0)
    server1.list_goal(Ros1Status.ACTIVE)
    assert client2.accepted(key)


def test_unknown_ros1_status_is_logged_and_ignored(
    bridge: both.Bridge, server1: Server1, client2: Client2
) -> None:
    begin(server1, client2, "listed")
    server1.list_goal(_UNKNOWN)
    bridge.wait_for_log(f"with the unknown status {_UNKNOWN}")
    server1.feed(_UNKNOWN)
    wait_until(lambda: client2.feedback["listed"], lambda: "no feedback")
    server1.end(Ros1Status.SUCCEEDED)
    wait_until(lambda: "listed" in client2.results, lambda: "no result")
    assert client2.results["listed"].status == Ros2Status.STATUS_SUCCEEDED
    assert client2.results["listed"].result.progress.phase == "odd"


@pytest.mark.parametrize("status", [_UNKNOWN, Ros1Status.ACTIVE])
def test_result_with_a_status_that_is_no_end_aborts_the_goal(
    bridge: both.Bridge, server1: Server1, client2: Client2, status: int
) -> None:
    begin(server1, client2, f"status {status}")
    server1.end(status)
    assert client2.end(f"status {status}") == Ros2Status.STATUS_ABORTED
    bridge.wait_for_log(f"status {int(status)} is not final")


def test_invalid_result_aborts_goal(
    bridge: both.Bridge, server1: Server1, client2: Client2
) -> None:
    begin(server1, client2, "short")
    server1.publish_nonsense()
    bridge.wait_for_log("/odd/arm: a result without a valid goal is ignored")
    server1.end(Ros1Status.SUCCEEDED, cut=3)
    assert client2.end("short") == Ros2Status.STATUS_ABORTED
    bridge.wait_for_log("is aborted, invalid result")


def test_missing_result_is_logged(bridge: both.Bridge, server1: Server1, client2: Client2) -> None:
    begin(server1, client2, "mute")
    server1.list_goal(Ros1Status.SUCCEEDED)
    assert client2.end("mute") == Ros2Status.STATUS_SUCCEEDED
    uuid = bytes(client2.handles["mute"].goal_id.uuid)
    bridge.wait_for_log(f"/odd/arm: no result of {text_of(uuid)}")


def test_text_in_other_encoding_keeps_alignment(server1: Server1, client2: Client2) -> None:
    begin(server1, client2, "latin")
    server1.end(Ros1Status.SUCCEEDED, why="für".encode("latin-1"))
    wait_until(lambda: "latin" in client2.results, lambda: "no result")
    assert client2.results["latin"].status == Ros2Status.STATUS_SUCCEEDED
    assert client2.results["latin"].result.progress.phase == "odd"


def test_invalid_feedback_is_logged_and_ignored(
    bridge: both.Bridge, server1: Server1, client2: Client2
) -> None:
    begin(server1, client2, "fed")
    before, began = len(bridge.logged("/odd/arm: feedback to ROS 2")), time.monotonic()
    for _ in range(20):
        server1.feed(Ros1Status.ACTIVE, cut=3)
    bridge.wait_for_log("/odd/arm: feedback to ROS 2")
    server1.feed(Ros1Status.ACTIVE)
    wait_until(lambda: client2.feedback["fed"], lambda: "no feedback")
    lines = len(bridge.logged("/odd/arm: feedback to ROS 2")) - before
    assert lines <= 2 + time.monotonic() - began, "more than one a second would fill the log"
    server1.end(Ros1Status.ABORTED)
    wait_until(lambda: "fed" in client2.results, lambda: "no result")


def test_times_outside_other_ros_range(
    ros: both.Both, bridge: both.Bridge, server1: Server1, client2: Client2
) -> None:
    begin(server1, client2, "late")
    server1.list_goal(Ros1Status.PREEMPTING, stamp=_LATE_S * 10**9)
    wait_until(
        lambda: client2.state("late") == Ros2Status.STATUS_CANCELING,
        lambda: str(client2.state("late")),
    )
    answer = cancel(ros, "/odd/arm", until=Time(sec=-1))  # before all goals
    assert answer.return_code == CancelGoal.Response.ERROR_NONE and not answer.goals_canceling
    server1.end(Ros1Status.PREEMPTED)
    wait_until(lambda: "late" in client2.results, lambda: "no result")
    assert not bridge.logged("Traceback")


class Server2:
    """A server of ROS 2 without rclpy's rules, which accepts all goals.

    :ivar accepted: their ids
    """

    def __init__(self, node: Node, name: str, answers: bool = True) -> None:
        self.accepted: List[bytes] = []
        impl, path = GoTo.Impl, f"{name}/_action"
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._status = node.create_publisher(Statuses2, f"{path}/status", kept)
        node.create_publisher(impl.FeedbackMessage, f"{path}/feedback", 10)
        node.create_service(impl.SendGoalService, f"{path}/send_goal", self._accept)
        answer = self._answer if answers else self._wait
        node.create_service(impl.GetResultService, f"{path}/get_result", answer)
        node.create_service(CancelGoal, f"{path}/cancel_goal", lambda _, response: response)

    def _accept(self, request: Any, response: Any) -> Any:
        self.accepted.append(bytes(request.goal_id.uuid))
        response.accepted = True
        return response

    @staticmethod
    def _answer(_: Any, response: Any) -> Any:
        response.status = _UNKNOWN
        return response

    @staticmethod
    async def _wait(*_: Any) -> None:
        await Future()

    def list_goal(self, status: int, sec: int, uuid: bytes = bytes([7] * 16)) -> None:
        """Publish a goal that began at a time [s]."""
        info = GoalInfo(goal_id=UUID(uuid=list(uuid)), stamp=Time(sec=sec))
        self._status.publish(Statuses2(status_list=[Ros2Status(goal_info=info, status=status)]))


@pytest.fixture(scope="module")
def server2(ros: both.Both, bridge: both.Bridge) -> Iterator[Server2]:
    node = Node("odd_hand")
    made = Server2(node, "/odd/hand")
    ros.executor.add_node(node)
    yield made
    ros.executor.remove_node(node)
    node.destroy_node()


def test_unknown_ros2_status_is_logged_and_result_aborts(
    ros: both.Both, bridge: both.Bridge, server2: Server2
) -> None:
    with Client1("/odd/hand") as client:
        client.tell("send one 60.0")
        assert client.end_of("one") == f"ABORTED - {NO_END}"
        bridge.wait_for_log(f"/odd/hand: the server in ROS 2 sends the unknown status {_UNKNOWN}")
    server2.list_goal(_UNKNOWN + 1, sec=1)
    bridge.wait_for_log(f"/odd/hand: the server in ROS 2 sends the unknown status {_UNKNOWN + 1}")
    server2.list_goal(Ros2Status.STATUS_EXECUTING, sec=-1)
    recorder = ros.hear1("/odd/hand/status", "actionlib_msgs/GoalStatusArray")
    theirs = struct.pack("<II", 0, 0) + struct.pack("<I", 36) + b"07070707-"
    wait_until(lambda: any(theirs in m._buff for m in recorder.heard), lambda: "not listed")
    recorder.end()
    assert not bridge.logged("Traceback")


def test_invalid_goal_is_logged(ros: both.Both, bridge: both.Bridge, server2: Server2) -> None:
    raw = ros.types.action("bot_controller_demo_msgs/GoTo").raw_goal
    publisher = rospy.Publisher("/odd/hand/goal", raw, queue_size=10)
    wait_until(publisher.get_num_connections, lambda: "no connection")
    message = raw()
    message._buff = b"nonsense" * 2
    publisher.publish(message)
    bridge.wait_for_log("/odd/hand: a goal from ROS 1 without an id is ignored")
    publisher.unregister()


def test_ended_goal_without_result(ros: both.Both, bridge: both.Bridge) -> None:
    node = Node("odd_foot")
    server = Server2(node, "/odd/foot", answers=False)
    ros.executor.add_node(node)
    with Client1("/odd/foot") as client:
        client.tell("send one 60.0")
        wait_until(lambda: server.accepted, lambda: "no goal")
        server.list_goal(Ros2Status.STATUS_EXECUTING, 1, server.accepted[0])
        server.list_goal(Ros2Status.STATUS_SUCCEEDED, 1, server.accepted[0])
        assert client.end_of("one") == f"SUCCEEDED - {NO_RESULT}"
        bridge.wait_for_log("/odd/foot: no result of")
    ros.executor.remove_node(node)
    node.destroy_node()


def test_goal_that_cannot_reach_its_server_is_rejected_with_a_warning(
    ros: both.Both, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)
    server: Any = Ros1ServerInRos2.__new__(Ros1ServerInRos2)
    server._name, server.kind = "/arm", ros.types.action("bot_controller_demo_msgs/GoTo")
    server._goals = SimpleNamespace(request_goal=pytest.fail)
    request = GoTo.Impl.SendGoalService.Request()
    request.goal.target_pose.header.stamp.sec = -1  # which ROS 1 cannot represent
    sent: List[Any] = []
    for is_connected in (False, True):
        server._is_connected = lambda is_connected=is_connected: is_connected
        server._answer_goal(request, sent.append)
    assert [response.accepted for response in sent] == [False, False]
    first, second = lines
    assert first == "/arm is not connected: a goal from ROS 2 is rejected"
    assert second.startswith("/arm: a goal from ROS 2 is rejected: ")


def test_goal_without_id_and_time_gets_both(ros: both.Both) -> None:
    server: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    server._node, server._name = SimpleNamespace(name="/bridge"), "/hand"
    server._numbers, server._lock = itertools.count(1), threading.Lock()
    given: List[Any] = []
    server._goals = SimpleNamespace(request_goal=lambda *values: given.append(values))
    for text, stamp in (("", 0), ("mine", 7)):
        server._on_goal(actionlib_messages.write_goal(SimpleNamespace, text, stamp, b""))
    (first, began, _), (second, stamp, _) = given
    assert began > 0 and first == f"/bridge-1-{began}"
    assert (second, stamp) == ("mine", 7)


def test_feedback_and_lists_that_are_malformed_keep_no_other_from_arriving(
    ros: both.Both, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lines.append)

    def to_ros1(cdr: bytes) -> bytes:
        if cdr.endswith(b"late"):
            raise ConversionError("a time before 1970")
        return cdr[4:]

    sent: List[Any] = []
    server: Any = Ros2ServerInRos1.__new__(Ros2ServerInRos1)
    server._name, server._lock, server._is_offered = "/hand", threading.Lock(), True
    server._throttle = Throttle(60.0)
    feedback = SimpleNamespace(to_ros1=to_ros1)
    server.kind = SimpleNamespace(feedback=feedback, raw_feedback=SimpleNamespace)
    server._feedback1 = SimpleNamespace(publish=sent.append)
    goal = Goal("mine", bytes(16), 7, 0.0, True)
    server._goals = SimpleNamespace(under_way=lambda _: goal)
    arrived = (b"half", b"late", b"late", b"done")
    server._on_feedback([SimpleNamespace(data=bytes(20) + end) for end in arrived])
    assert [message._buff[-4:] for message in sent] == [b"half", b"done"]
    assert lines == ["/hand: feedback to ROS 1: a time before 1970"]
    listed: List[Any] = []
    server._goals.on_status = lambda *given: listed.append(given[:2]) or []
    good = write_list([ListedGoal(bytes(16), 7, Ros2Status.STATUS_EXECUTING)])
    for lists in ((b"", good), (b"",)):
        server._on_status([SimpleNamespace(data=data, sender=b"us") for data in lists])
    assert listed == [([(bytes(16), 7, Ros2Status.STATUS_EXECUTING)], b"us")]
    assert len(lines) == 2 and lines[1].startswith("/hand: invalid list of goals from ROS 2: ")
