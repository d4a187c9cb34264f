"""Invalid odometry: the robot stops, and the log gives the reason."""

import math
import types
from typing import Any, Callable, Dict, List, Optional, Tuple

import pytest
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from bot_controller_demo.control.geometry import Goal, pose_fault
from bot_controller_demo.control.staleness import Staleness
from bot_controller_demo.driving.driver import Driver
from bot_controller_demo.nodes.proportional_controller import ProportionalControllerParameters
from bot_controller_demo_msgs.msg import Progress


class FakeNode:
    """Takes the driver's callback, and passes its commands on."""

    on_command: Callable[[Any], None]

    def __init__(self) -> None:
        self.callbacks: Dict[str, Callable[[Any], None]] = {}

    def resolve(self, name: str) -> str:
        return f"/lab/{name}"

    def create_publisher(self, name: str, _type: type, **_options: Any) -> Any:
        take = self.on_command if name == "cmd_vel" else lambda message: None
        return types.SimpleNamespace(publish=take)

    def create_subscription(self, name: str, _type: type, callback: Any, **_options: Any) -> None:
        self.callbacks[name] = callback

    def own(self, thing: Any) -> Any:
        return thing

    def before_deactivate(self, callback: Any) -> None:
        """Fake deactivation that never happens."""

    on_shutdown = before_deactivate


class Bench:
    """A driver with a goal, a fake clock, and its log lines."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.now = 100.0
        self.log: List[Tuple[str, str]] = []
        monkeypatch.setattr(rospy, "get_time", lambda: self.now)
        monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time.from_sec(self.now))
        for level in ("loginfo", "logwarn"):
            monkeypatch.setattr(
                rospy,
                level,
                lambda text, *args, level=level: self.log.append((level, text % args)),
            )
        self.node = FakeNode()
        self.is_driving = False
        self.progress: Optional[Progress] = None
        self.node.on_command = self._on_command
        values = ProportionalControllerParameters()
        node: Any = self.node
        live: Any = types.SimpleNamespace(values=values)
        self.driver = Driver(node, live)
        self.driver.head_for(Goal(5.0, 0.0))
        self.log.clear()

    def _on_command(self, message: Twist) -> None:
        # Commands reuses one message.
        self.is_driving = bool(message.linear.x or message.angular.z)

    def step(self, w: float = 1.0, x: float = 0.0, behind: float = 0.0) -> bool:
        """Deliver odometry, and step the driver; return whether the robot drives."""
        self.now += 0.05
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(self.now - behind)
        message.header.frame_id = "map"
        message.pose.pose.orientation.w = w
        message.pose.pose.position.x = x
        self.node.callbacks["odom"](message)
        self.progress = self.driver.step()
        return self.is_driving


@pytest.fixture()
def bench(monkeypatch: "pytest.MonkeyPatch") -> Bench:
    return Bench(monkeypatch)


@pytest.mark.parametrize(
    "unusable, reason",
    [
        ({"w": 0.0}, "cannot be used (orientation (0, 0, 0, 0): not a quaternion)"),
        (
            {"x": math.nan},
            "cannot be used (position (nan, 0), orientation (0, 0, 0, 1): not finite)",
        ),
        (
            {"w": math.inf},
            "cannot be used (position (0, 0), orientation (0, 0, 0, inf): not finite)",
        ),
        ({"behind": 3.0}, "has stamps 3.00 s behind this clock"),
    ],
)
def test_unusable_odometry_stops_the_robot_and_is_named_once(
    bench: Bench, unusable: Dict[str, float], reason: str
) -> None:
    assert not any([bench.step(**unusable) for _ in range(40)]), "the robot drives blindly"
    [(level, line)] = bench.log
    assert level == "logwarn" and line.startswith(f"/lab/odom {reason}") and "stopped" in line
    assert bench.step()
    assert bench.log[1:] == [("loginfo", "receiving odometry: the robot drives")]
    drives = [bench.step(**unusable) for _ in range(40)]
    assert not drives[-1]
    assert [line for _, line in bench.log[2:] if reason in line]


def test_progress_has_the_stamp_and_the_frame_of_the_odometry(bench: Bench) -> None:
    for _ in range(2):
        assert bench.step(behind=0.02) and bench.progress is not None
        header = bench.progress.header
        assert (header.stamp.to_sec(), header.frame_id) == (pytest.approx(bench.now - 0.02), "map")


def test_time_without_odometry_is_not_without_progress(bench: Bench) -> None:
    assert bench.step()
    bench.now += 100.0
    assert bench.driver.step() is None
    assert [bench.step() for _ in range(10)] == [True] * 10


def test_missing_odometry_is_waited_for_without_a_warning(bench: Bench) -> None:
    for _ in range(10):
        bench.driver.step()
    assert bench.log == [("loginfo", "waiting for odometry on /lab/odom")]


@pytest.mark.parametrize("orientation", [(0.0, 0.0, 1.0, 1.0), (0.0, 0.0, 0.0, -2.0)])
def test_quaternion_of_any_length_is_a_pose(orientation: Tuple[float, ...]) -> None:
    assert pose_fault((1.0, 2.0), orientation) == ""


def test_quaternion_too_short_for_a_heading_is_refused() -> None:
    assert pose_fault((0.0, 0.0), (0.0, 0.0, 0.0, 1e-200)).endswith("not a quaternion")


def test_skew_is_that_of_messages_that_arrive_in_time() -> None:
    staleness = Staleness()
    assert staleness.skew(10.0, 0.5) == 0.0
    staleness.record_message(7.0, 10.0)
    assert staleness.skew(10.2, 0.5) == pytest.approx(3.0)
    assert staleness.skew(10.6, 0.5) == 0.0, "no messages arrive"
    staleness.record_message(9.9, 10.0)
    assert staleness.skew(10.0, 0.5) == 0.0
    staleness.record_message(99.0, 10.0)
    assert staleness.skew(10.0, 0.5) == 0.0, "by a clock that is ahead"
