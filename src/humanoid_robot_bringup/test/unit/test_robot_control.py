"""Arrival as detected by robot_control.py, and its log."""

import math
from types import SimpleNamespace
from typing import Any, Dict, List

import pytest
import rospy
from geometry_msgs.msg import PoseStamped

from bot_controller_demo_msgs.msg import Progress
from humanoid_robot_bringup import robot_control
from humanoid_robot_bringup.robot_control import RobotControl, RobotControlParameters
from nodekit import CallCancelled, CallError


class FakeNode:
    """Fake node and controller: accepts each goal immediately."""

    def __init__(self) -> None:
        self.values = RobotControlParameters()
        self.callbacks: Dict[Any, Any] = {}
        self.tick: Any = None

    def hear(self, message: Any) -> None:
        self.callbacks[type(message)](message)

    def declare_parameters(self, declaration: Any, on_change: Any) -> "FakeNode":
        return self

    def create_client(self, name: str, kind: Any) -> "FakeNode":
        return self

    def create_subscription(self, name: str, kind: Any, callback: Any) -> None:
        self.callbacks[kind] = callback

    def create_timer(self, rate: float, callback: Any) -> None:
        self.tick = callback

    def call_async(self, request: Any) -> "FakeNode":
        return self

    def add_done_callback(self, callback: Any) -> None:
        callback(self)

    def result(self) -> "FakeNode":
        return self

    message, success = "x 0 m", True


def progress(phase: str, second: float) -> Progress:
    """Return the controller's progress, computed from odometry of a time."""
    told = Progress(phase=phase)
    told.header.stamp = rospy.Time.from_sec(second)
    return told


def test_only_news_of_the_goal_that_was_set_is_an_arrival(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    ended: List[str] = []
    monkeypatch.setattr(rospy, "signal_shutdown", ended.append)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(10))
    node: Any = FakeNode()
    RobotControl(node)
    node.hear(progress(Progress.ARRIVED, 11.0))  # no goal was set: it is at another one
    node.tick(0.0)
    node.hear(progress(Progress.ARRIVED, 9.9))  # on its way when the goal was set
    node.hear(progress(Progress.ARRIVED, 10.0))
    node.hear(progress(Progress.DRIVING, 10.1))
    assert ended == []
    node.hear(progress(Progress.ARRIVED, 20.0))
    assert ended == ["arrived"]


@pytest.mark.parametrize(
    "error, told",
    [(CallCancelled("over"), []), (CallError("no server"), ["cannot send the robot: no server"])],
)
def test_failed_call_is_logged_unless_by_shutdown(
    monkeypatch: "pytest.MonkeyPatch", error: CallError, told: List[str]
) -> None:
    warned: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: warned.append(text % values))

    def fail(_node: FakeNode) -> None:
        raise error

    monkeypatch.setattr(FakeNode, "result", fail)
    node: Any = FakeNode()
    RobotControl(node)
    node.tick(0.0)
    assert warned == told


def goal(second: float, x: float = 0.0, theta: float = 0.0) -> PoseStamped:
    """Return the controller's message about the goal that was set at a time."""
    told = PoseStamped()
    told.header.stamp = rospy.Time.from_sec(second)
    told.pose.position.x = x
    told.pose.orientation.z, told.pose.orientation.w = math.sin(theta / 2.0), math.cos(theta / 2.0)
    return told


@pytest.mark.parametrize(
    "told, is_over",
    [
        (goal(9.0, x=5.0), False),  # the previous goal
        (goal(11.0, theta=2.0 * math.pi), False),  # ours, as it is told again in another frame
        (goal(11.0, x=5.0), True),
        (goal(11.0, theta=1.0), True),
    ],
)
def test_robot_that_somebody_else_sends_elsewhere_is_given_up(
    monkeypatch: "pytest.MonkeyPatch", told: PoseStamped, is_over: bool
) -> None:
    given_up: List[str] = []
    monkeypatch.setattr(robot_control, "abort", given_up.append)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(10))
    node: Any = FakeNode()
    RobotControl(node)
    node.tick(0.0)
    node.hear(told)
    where = f"the robot was sent elsewhere: to x {told.pose.position.x:g} m, y 0 m"
    assert given_up == [where] * is_over


def test_distance_is_logged_while_known(monkeypatch: "pytest.MonkeyPatch") -> None:
    said: List[str] = []
    for level in ("loginfo", "logwarn"):
        monkeypatch.setattr(rospy, level, lambda text, *values: said.append(text % values))
    node: Any = FakeNode()
    RobotControl(node)

    def tick_at(second: float) -> List[str]:
        monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time.from_sec(second))
        said.clear()
        node.tick(0.0)
        return list(said)

    assert tick_at(10.0) == ["the robot goes to x 0 m"]
    assert tick_at(11.0) == []
    node.hear(progress(Progress.DRIVING, 11.0))
    assert tick_at(13.0) == ["driving: 0.00 m are left"]
    assert tick_at(16.0) == ["the controller has told no progress for 5 s"]
    node.hear(progress(Progress.DRIVING, 16.0))
    assert tick_at(17.0) == ["driving: 0.00 m are left"]


class SlowNode(FakeNode):
    """Fake controller that answers on request; it keeps the goals it was given."""

    def __init__(self) -> None:
        super().__init__()
        self.calls: List[Any] = []

    def call_async(self, request: Any) -> Any:
        answer = SimpleNamespace(message="", success=True, goal=request.x)
        answer.result = lambda: answer
        answer.add_done_callback = lambda callback: setattr(answer, "answer", callback)
        self.calls.append(answer)
        return answer

    @property
    def goals(self) -> List[float]:
        return [call.goal for call in self.calls]


def test_goal_that_is_changed_while_the_controller_is_asked_is_sent_too() -> None:
    node: Any = SlowNode()
    control = RobotControl(node)
    node.tick(0.0)
    old, node.values = node.values, RobotControlParameters(x=2.0)
    control._on_change(node.values, old)
    node.calls[0].answer(node.calls[0])
    node.tick(0.0)
    assert node.goals == [0.0, 2.0]


def test_refused_goal_is_sent_again(monkeypatch: "pytest.MonkeyPatch") -> None:
    warnings: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: warnings.append(text % values))
    node: Any = SlowNode()
    RobotControl(node)
    node.tick(0.0)
    node.calls[0].success, node.calls[0].message = False, "too far"
    node.calls[0].answer(node.calls[0])
    node.tick(0.0)
    assert node.goals == [0.0, 0.0]
    assert warnings == ["cannot send the robot: too far"]
