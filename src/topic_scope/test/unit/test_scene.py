"""Scene of robots sent to a page, from messages of any node."""

import json
import math
from typing import Any, Dict, List
from unittest import mock

import numpy
import pytest
import rospy
from geometry_msgs.msg import Point, PoseStamped, TransformStamped
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import LaserScan
from bags import nanoseconds
from test_message_reader import serialized
from test_recorder import FakeSubscription, header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from topic_scope.messages.layout_cache import Layouts
from topic_scope.messages.message_layout import layout_of, parse
from topic_scope.messages.message_reader import MessageReader
from topic_scope.page.open_page import Page
from topic_scope.robots import scene
from topic_scope.robots.scene import Scene
from topic_scope.robots.scene_feed import SceneFeed
from topic_scope.sampling.message_source import Batch


def turn(orientation: Any, angle: float) -> None:
    orientation.z, orientation.w = math.sin(angle / 2), math.cos(angle / 2)


def odometry(x: float, y: float, heading: float, frame: str = "odom") -> Odometry:
    message = Odometry(child_frame_id=frame.replace("odom", "base"))
    message.header.frame_id = frame
    message.pose.pose.position = Point(x, y, 0.0)
    turn(message.pose.pose.orientation, heading)
    message.twist.twist.linear.x, message.twist.twist.angular.z = 0.25, -0.5
    return message


def scan(frame: str, *ranges: float) -> LaserScan:
    message = LaserScan(ranges=ranges, range_min=0.1, range_max=3.5, angle_increment=0.5)
    message.header.frame_id = frame
    return message


def transforms(parent: str, child: str, x: float) -> TFMessage:
    one = TransformStamped(child_frame_id=child)
    one.header.frame_id, one.transform.translation.x = parent, x
    return TFMessage([one])


def receive(shown: Scene, topic: str, message: Any, now: float = 0.0) -> None:
    read = MessageReader(layout_of(type(message))).read(serialized(message))
    shown.add_message(topic, message._type, read, now)


def as_json(message: Dict[str, Any]) -> Dict[str, Any]:
    """Return the message in JSON form."""
    text: Dict[str, Any] = json.loads(json.dumps(message, allow_nan=False))
    return text


def test_robots_have_place_heading_and_speed_until_they_are_silent() -> None:
    shown = Scene()
    receive(shown, "/odom", odometry(1.0, 2.0, 3.0), 10.0)
    (robot,) = as_json(shown.moving(10.5))["robots"]
    assert robot["heading"] == pytest.approx(3.0, abs=1e-4)
    assert (robot["x"], robot["y"], robot["speed"], robot["turn"]) == (1.0, 2.0, 0.25, -0.5)
    assert (robot["topic"], robot["frame"], robot["silent"]) == ("/odom", "odom", False)
    assert robot["body"] == "base"
    assert as_json(shown.moving(11.5))["robots"][0]["silent"]
    receive(shown, "/odom", odometry(math.nan, 0.0, 0.0), 12.0)
    assert as_json(shown.moving(12.0))["robots"][0]["x"] == 1.0
    shown.keep({})
    assert shown.moving(12.0)["robots"] == []


def test_scan_is_placed_at_its_laser() -> None:
    shown = Scene()
    receive(shown, "/robot1/odom", odometry(1.0, 0.0, math.pi / 2, "robot1/odom"))
    receive(shown, "/robot1/scan", scan("robot1/laser", 1.0, math.inf, math.nan, 0.05, 3.0))
    # Without a transform, the laser is assumed to be on the robot of its namespace.
    (seen,) = as_json(shown.moving(0.0))["scans"]
    assert seen["at"] == pytest.approx([0.0, 1.0, -1.0, 0.0, 1.0, 0.0], abs=1e-4)
    assert seen["ranges"] == [1000, 0, 0, 0, 3000]
    receive(shown, "/tf", transforms("robot1/base", "robot1/laser", 0.5))
    assert as_json(shown.moving(0.0))["scans"][0]["at"][4:] == pytest.approx([1.0, 0.5], abs=1e-4)
    assert shown.moving(5.0)["scans"] == []
    # The robot of another namespace does not carry it; an echo from 2000 km is invalid.
    far = scan("lone/laser", 2e6, 1.0)
    far.range_max = math.inf
    receive(shown, "/lone/scan", far)
    assert [one["topic"] for one in shown.moving(0.0)["scans"]] == ["/robot1/scan"]
    receive(shown, "/lone/odom", odometry(0.0, 0.0, 0.0, "lone/odom"))
    assert shown.moving(0.0)["scans"][0]["ranges"] == [0, 1000]


def test_scan_is_thinned_out_and_an_invalid_scan_is_empty() -> None:
    shown = Scene()
    receive(shown, "/odom", odometry(0.0, 0.0, 0.0))
    receive(shown, "/scan", scan("base", *[1.0] * 5000))
    (seen,) = shown.moving(0.0)["scans"]
    assert len(seen["ranges"]) == 1667 and seen["step"] == pytest.approx(1.5)
    nonsense = scan("base", 1.0)
    nonsense.angle_min = math.nan
    receive(shown, "/scan", nonsense)
    assert as_json(shown.moving(0.0))["scans"][0]["ranges"] == [0]


def test_markers_come_and_go_one_by_one() -> None:
    shown = Scene()
    wall = Marker(ns="walls", type=Marker.LINE_LIST, points=[Point(0, 1, 0), Point(2, 3, 0)])
    box = Marker(ns="boxes", id=4, type=Marker.CUBE)
    box.pose.position.x, box.scale.x, box.color.r = 1.5, 0.4, math.nan
    receive(shown, "/world", MarkerArray([Marker(action=Marker.DELETEALL), wall, box]))
    lines, cube = as_json(shown.standing(0.0))["markers"]
    assert (lines["kind"], lines["points"]) == ("lines", [0.0, 1.0, 2.0, 3.0])
    assert (cube["kind"], cube["size"], cube["at"][4]) == ("box", [0.4, 0.0], 1.5)
    receive(shown, "/world", MarkerArray([Marker(ns="walls", action=Marker.DELETE)]))
    assert [one["kind"] for one in shown.standing(0.0)["markers"]] == ["box"]
    receive(shown, "/other", box)
    receive(shown, "/world", MarkerArray([Marker(action=Marker.DELETEALL)]))
    assert len(shown.standing(0.0)["markers"]) == 1


def test_marker_expires_after_its_lifetime() -> None:
    shown = Scene()
    brief = Marker(ns="brief", type=Marker.CUBE, lifetime=rospy.Duration(0.5))
    receive(shown, "/world", MarkerArray([brief, Marker(ns="lasting", type=Marker.SPHERE)]), 10.0)

    def types(now: float) -> List[str]:
        return [one["kind"] for one in shown.standing(now)["markers"]]

    assert types(10.4) == ["box", "disc"]
    receive(shown, "/world", brief, 10.4)
    assert types(10.8) == ["box", "disc"]
    assert types(11.0) == ["disc"] == types(1e9)


def test_full_topic_still_updates_its_markers(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr("topic_scope.robots.markers._MARKERS", 1)
    shown = Scene()
    for number, kind in ((1, Marker.CUBE), (2, Marker.CUBE), (1, Marker.SPHERE)):
        receive(shown, "/world", Marker(id=number, type=kind))
    assert [one["kind"] for one in shown.standing(0.0)["markers"]] == ["disc"]


def test_frames_of_removed_topics_are_dropped() -> None:
    shown = Scene()
    topics = ["/a/odom", "/goal", "/tf", "/tf_static"]
    goal = PoseStamped()
    goal.header.frame_id = "base"
    receive(shown, "/tf_static", transforms("map", "odom", 100.0))
    receive(shown, "/tf", transforms("odom", "base", 20.0))
    receive(shown, "/a/odom", odometry(3.0, 0.0, 0.0))
    receive(shown, "/goal", goal)

    def x() -> float:
        shown.keep(dict.fromkeys(topics, ""))
        return float(shown.standing(0.0)["goals"][0]["x"])

    assert x() == 120.0
    topics.remove("/tf")
    assert x() == 103.0
    topics.remove("/a/odom")
    assert x() == 0.0
    topics.append("/b/odom")  # after the other topic by name, which no longer blocks it
    receive(shown, "/b/odom", odometry(4.0, 0.0, 0.0))
    assert x() == 104.0
    topics.remove("/tf_static")
    assert x() == 4.0


def test_paths_and_goals() -> None:
    shown = Scene()
    receive(shown, "/tf", transforms("map", "odom", 1.0))
    goal = PoseStamped()
    goal.header.frame_id, goal.pose.position.y = "odom", 2.0
    path = Path(poses=[goal, goal])
    path.header.frame_id = "map"
    receive(shown, "/goal", goal)
    receive(shown, "/plan", path)
    standing = as_json(shown.standing(0.0))
    assert standing["goals"] == [{"topic": "/goal", "x": 1.0, "y": 2.0, "heading": 0.0}]
    assert standing["paths"][0]["points"] == [0.0, 2.0, 0.0, 2.0]


def test_long_path_is_shown_up_to_its_end(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(scene, "_POINTS", 2)
    shown, poses = Scene(), [PoseStamped() for _ in range(3)]
    for index, pose in enumerate(poses):
        pose.pose.position.x = float(index)
    receive(shown, "/plan", Path(poses=poses))
    assert shown.standing(0.0)["paths"][0]["points"] == [1.0, 0.0, 2.0, 0.0]


STATUS = "string robot_name\nuint8 mode\nfloat32[] sensor_readings\n"


def test_status_is_recognised_by_its_fields() -> None:
    assert scene.is_status(parse("other_msgs/State", STATUS + "float32 more\n"))
    texts = STATUS.replace("float32[]", "string[]"), STATUS.replace("string", "int8")
    for text in ("", STATUS.replace("[]", ""), *texts, "uint8 mode\n"):
        assert not scene.is_status(parse("a/RobotStatus", text))
    assert not scene.is_status(None)


def test_the_fleet_has_a_tile_for_each_robot_by_name() -> None:
    shown = Scene()
    for topic, name in (("/a", "zoe"), ("/b", "al")):
        readings = numpy.array([11.10000038, math.nan])
        message = {"robot_name": name, "mode": 1, "sensor_readings": readings}
        shown.add_message(topic, "x/RobotStatus", message, 0.0)
    first, second = as_json(shown.fleet(0.5))["robots"]
    assert first == {"topic": "/b", "name": "al", "mode": 1, "readings": [11.1, None], "age": None}
    assert second["name"] == "zoe" and shown.fleet(3.25)["robots"][0]["age"] == 3.2
    shown.keep({"/a": "x/RobotStatus"})
    assert [one["name"] for one in shown.fleet(0.5)["robots"]] == ["zoe"]


def test_message_with_wrong_fields_is_rejected() -> None:
    for datatype in scene.TYPES:
        with pytest.raises((LookupError, TypeError, ValueError)):
            Scene().add_message("/x", datatype, {"data": 1.0}, 0.0)


def test_page_that_enters_after_the_last_one_left_gets_no_outdated_scene() -> None:
    source = mock.Mock(**{"clock.now.return_value": 1.0, "subscriptions.return_value": {}})
    feed = SceneFeed(source, Layouts())
    first, later = Page(5.0), Page(5.0)
    feed.enter(first)
    feed.update()
    assert [message["type"] for message in first.pop_messages()] == ["robots"]
    feed.leave(first)
    feed.enter(later)
    assert later.pop_messages() == []
    source.subscriptions.reset_mock()
    feed.leave(later)
    feed.update()  # nothing to do without pages
    source.subscriptions.assert_not_called()


class Fed:
    """Feed of a scene, and a page that shows it."""

    def __init__(self) -> None:
        self.topics: Dict[str, FakeSubscription] = {}
        self.source = mock.Mock(**{"clock.now.return_value": 1.0})
        self.source.subscriptions.return_value = self.topics
        self.feed, self.page = SceneFeed(self.source, Layouts()), Page(5.0)
        self.feed.enter(self.page)

    def receive(self, topic: str, *messages: Any) -> None:
        data = [serialized(message) for message in messages]
        subscription = self.topics.setdefault(topic, FakeSubscription())
        batch = Batch(header(type(messages[0])), nanoseconds([1.0] * len(data)), data)
        subscription.batches.append(batch)

    def shown(self) -> Dict[str, Any]:
        """Return the messages of the next updates, by type."""
        for _ in range(5):
            self.feed.update()
        return {message["type"]: message for message in self.page.pop_messages()}


def test_feed_shows_all_markers_of_a_batch_and_the_latest_pose() -> None:
    fed = Fed()
    fed.feed.set_topics({"/w": Marker._type, "/odom": Odometry._type, "/x": "std_msgs/Float32"})
    fed.source.want.assert_called_once_with(["/w", "/odom"])
    fed.receive("/w", Marker(id=1), Marker(id=2))
    fed.receive("/odom", odometry(1.0, 0.0, 0.0), odometry(2.0, 0.0, 0.0))
    fed.receive("/late", odometry(3.0, 0.0, 0.0))  # no longer requested
    shown = fed.shown()
    assert [robot["x"] for robot in shown["robots"]["robots"]] == [2.0]
    assert len(shown["scenery"]["markers"]) == 2 and shown["fleet"]["robots"] == []
    second = Page(5.0)
    fed.feed.enter(second)  # while the other shows it
    assert {one["type"] for one in second.pop_messages()} == {"robots", "scenery", "fleet"}


def test_feed_drops_removed_topics_and_the_past_of_another_time() -> None:
    fed = Fed()
    both = {"/odom": Odometry._type, "/b/odom": Odometry._type}
    fed.feed.set_topics(both)
    for topic in both:
        fed.receive(topic, odometry(1.0, 0.0, 0.0))
    assert len(fed.shown()["robots"]["robots"]) == 2
    fed.feed.set_topics({"/odom": Odometry._type})
    assert [one["topic"] for one in fed.shown()["robots"]["robots"]] == ["/odom"]
    fed.feed.forget()
    assert fed.shown()["robots"]["robots"] == []
    fed.feed.leave(fed.page)
    fed.feed.set_topics(both)
    assert fed.source.want.call_args[0] == ([],)
