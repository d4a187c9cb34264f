"""Robots and the pages that drive them; nodes, publishers and threads are fakes."""

import math
from types import SimpleNamespace
from typing import Any, Dict, List, Tuple
from unittest import mock

import pytest
import rospy
from test_parameter_sender import SlowWorker

from topic_scope.graph.master_watch import GraphState
from topic_scope.page.open_page import Page
from topic_scope.protocol.requests import Drive, Goal
from topic_scope.robots import driving
from topic_scope.robots.dead_man import Velocity

CMD, OTHER, GOAL = "/a/cmd_vel", "/b/cmd_vel", "/a/goal"
GO, STOP = Drive(0.5, -0.1, 7.0), Drive(0.0, 0.0, 7.0)


class FakeSession:
    """Drive session that records its commands."""

    datatype = "geometry_msgs/Twist"

    def __init__(self, topic: str, datatype: str) -> None:
        self.topic, self.closed = topic, 0
        self.commands: List[Tuple[Velocity, float]] = []
        self.is_on_time = True

    def drive(self, velocity: Velocity, sent: float) -> bool:
        self.commands.append((velocity, sent))
        return self.is_on_time

    def close(self) -> bool:
        self.closed += 1
        return True


class World:
    """Robots with subscribers, and the pages."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.worker = SlowWorker()
        self.sessions: List[FakeSession] = []
        self.publishers: List[mock.Mock] = []
        self.naps: List[float] = []
        self.queries = mock.Mock()
        self.queries.subscribed_type.return_value = FakeSession.datatype
        monkeypatch.setattr(driving, "NodeQueries", lambda _name: self.queries)
        monkeypatch.setattr(driving, "DriveSession", self.session)
        clock = SimpleNamespace(sleep=self.naps.append, monotonic=lambda: 0.0)
        monkeypatch.setattr(driving, "time", clock)
        monkeypatch.setattr(rospy, "Publisher", self.publisher)
        monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(12))
        node = mock.Mock()
        node.name = "/scope"
        self.driving = driving.Driving(node, self.worker)
        (self.shut_down,) = node.on_shutdown.call_args[0]
        topics = [(CMD, ["/robot", "/scope"]), (OTHER, ["/robot"]), (GOAL, ["/robot"])]
        subscribers = [*topics, ("/own", ["/scope"]), ("/x", ["/y"])]
        types = {CMD: "geometry_msgs/Twist", OTHER: "geometry_msgs/TwistStamped"}
        types.update({GOAL: "geometry_msgs/PoseStamped", "/own": "geometry_msgs/Twist"})
        self.driving.on_state(GraphState([], subscribers, [], types))
        self.page, self.rival = Page(5.0), Page(5.0)

    def session(self, topic: str, datatype: str) -> FakeSession:
        self.sessions.append(FakeSession(topic, datatype))
        return self.sessions[-1]

    def publisher(self, topic: str, *_: Any, **__: Any) -> mock.Mock:
        self.publishers.append(mock.Mock(topic=topic))
        return self.publishers[-1]

    def work(self) -> None:
        while self.worker.work:
            self.worker.work.pop(0)()

    def take(self, page: Page, topic: str) -> None:
        self.driving.steer(page, topic)
        self.work()

    def closed(self) -> List[int]:
        return [one.closed for one in self.sessions]


@pytest.fixture
def world(monkeypatch: "pytest.MonkeyPatch") -> World:
    return World(monkeypatch)


def messages(page: Page) -> List[Tuple[str, str]]:
    """Return type, and topic or text, of the messages that wait for a page."""
    found: List[Dict[str, Any]] = page.pop_messages()
    return [(one["type"], one.get("topic", one.get("text"))) for one in found]


def test_robots_are_those_with_other_subscribers_than_the_scope(world: World) -> None:
    assert world.driving.targets() == {
        "type": "targets",
        "commands": [CMD, OTHER],
        "goals": [GOAL],
    }
    with pytest.raises(ValueError, match="no subscriber of /own"):
        world.driving.steer(world.page, "/own")
    world.take(world.page, CMD)
    topic, nodes, known = world.queries.subscribed_type.call_args[0]
    assert (topic, nodes, sorted(known)) == (
        CMD,
        ["/robot"],
        ["geometry_msgs/Twist", "geometry_msgs/TwistStamped"],
    )


def test_page_drives_only_what_it_has_taken(world: World) -> None:
    with pytest.raises(ValueError, match="take the wheel first"):
        world.driving.drive(world.page, GO)
    world.driving.drive(world.page, STOP)  # of a page that has just been replaced
    world.take(world.page, CMD)
    assert messages(world.page) == [("steering", CMD)]
    world.take(world.rival, OTHER)
    world.driving.drive(world.page, GO)
    first, second = world.sessions
    assert first.commands == [(Velocity(0.5, -0.1), 7.0)] and second.commands == []
    first.is_on_time = False
    with pytest.raises(ValueError, match="arrived too late"):
        world.driving.drive(world.page, GO)


def test_wheel_passes_to_the_page_that_takes_it_last(world: World) -> None:
    world.take(world.page, CMD)
    world.take(world.rival, CMD)
    text = "another page drives on /a/cmd_vel now"
    assert messages(world.page) == [("error", text), ("steering", "")]
    assert messages(world.rival) == [("steering", CMD)]
    assert world.closed() == [1, 0]
    world.take(world.rival, CMD)  # again
    assert messages(world.rival) == [("steering", CMD)] and world.closed() == [1, 1, 0]
    world.take(world.rival, OTHER)
    assert messages(world.rival) == [("steering", OTHER)] and world.closed() == [1, 1, 1, 0]
    world.take(world.rival, "")
    assert messages(world.rival) == [("steering", "")] and world.closed() == [1, 1, 1, 1]


def test_second_click_is_not_a_second_request(world: World) -> None:
    world.driving.steer(world.page, CMD)
    world.driving.steer(world.page, CMD)
    world.work()
    assert len(world.sessions) == 1 and world.closed() == [0]
    world.driving.leave(world.page)
    world.take(world.page, CMD)  # the first request has ended
    assert len(world.sessions) == 2


@pytest.mark.parametrize("other", [OTHER, ""])
def test_page_that_changes_its_mind_leaves_no_session(world: World, other: str) -> None:
    world.driving.steer(world.page, CMD)
    world.driving.steer(world.page, other)
    world.work()
    assert [one.topic for one in world.sessions if not one.closed] == [other] * bool(other)


def test_robot_without_a_known_type_is_reported(world: World) -> None:
    world.queries.subscribed_type.return_value = None
    world.take(world.page, CMD)
    text = "no subscriber of /a/cmd_vel takes a Twist or a TwistStamped"
    assert messages(world.page) == [("error", text)]
    world.driving.steer(world.page, CMD)
    with pytest.raises(ValueError, match="have not answered yet"):
        world.driving.steer(world.rival, CMD)


def test_all_robots_stop_at_the_end(world: World) -> None:
    world.take(world.page, CMD)
    world.take(world.rival, OTHER)
    world.driving.steer(Page(5.0), CMD)
    world.shut_down()
    assert world.closed() == [1, 1]
    assert world.naps == [0.5]  # until the zeros are sent
    world.work()
    assert world.closed()[-1] == 1  # the session that was made too late


def test_goal_has_its_pose_time_and_frame(world: World) -> None:
    world.queries.subscribed_type.return_value = "geometry_msgs/PoseStamped"
    for _ in range(2):
        world.driving.send(world.page, Goal(GOAL, "map", 1.0, -2.0, 3.0))
        world.work()
    assert messages(world.page) == [("sent", GOAL)]
    (publisher,) = world.publishers
    goal = publisher.publish.call_args[0][0]
    assert (goal.header.frame_id, goal.header.stamp) == ("map", rospy.Time(12))
    assert (goal.pose.position.x, goal.pose.position.y) == (1.0, -2.0)
    assert 2.0 * math.atan2(goal.pose.orientation.z, goal.pose.orientation.w) == pytest.approx(3.0)
    world.driving.rest()
    world.work()
    publisher.unregister.assert_called_once_with()
    world.driving.send(world.page, Goal(GOAL, "map", 1.0, -2.0, 3.0))
    world.work()
    assert len(world.publishers) == 2


def test_goal_that_cannot_be_sent_is_reported(world: World) -> None:
    world.queries.subscribed_type.return_value = None
    world.driving.send(world.page, Goal(GOAL, "map", 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="an earlier goal for /a/goal has not been sent yet"):
        world.driving.send(world.page, Goal(GOAL, "map", 0.0, 0.0, 0.0))
    world.work()
    assert messages(world.page) == [("error", "no subscriber of /a/goal takes a PoseStamped")]
    assert world.publishers == []
