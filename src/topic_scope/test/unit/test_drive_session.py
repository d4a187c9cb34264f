"""Commands of one driven robot, without a master."""

from typing import Any, Iterator, List
from unittest import mock

import pytest
import rospy

from nodekit.testing.waiting import wait_until
from topic_scope.robots import drive_session
from topic_scope.robots.dead_man import Velocity
from topic_scope.robots.drive_session import DriveSession


@pytest.fixture
def publisher(monkeypatch: "pytest.MonkeyPatch") -> Iterator[mock.Mock]:
    made = mock.Mock()
    monkeypatch.setattr(rospy, "Publisher", lambda *_, **__: made)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(12))
    monkeypatch.setattr(drive_session, "_LEAVING_S", 0.0)
    yield made


def published(publisher: mock.Mock) -> List[Any]:
    return [call[0][0] for call in publisher.publish.call_args_list]


def test_command_is_stamped_and_ends_with_a_single_zero(publisher: mock.Mock) -> None:
    session = DriveSession("/cmd_vel", "geometry_msgs/TwistStamped")
    assert session.drive(Velocity(0.5, -0.25), 3.0)
    wait_until(lambda: len(published(publisher)) > 1, lambda: "the robot does not stop")
    assert not session.close()
    wait_until(lambda: publisher.unregister.called, lambda: "the publisher is left")
    command, zero = published(publisher)
    assert (command.twist.linear.x, command.twist.angular.z) == (0.5, -0.25)
    assert (zero.twist.linear.x, zero.twist.angular.z) == (0.0, 0.0)
    assert command.header.stamp == zero.header.stamp == rospy.Time(12)


def test_closed_session_stops_its_robot_and_sends_nothing_else(publisher: mock.Mock) -> None:
    session = DriveSession("/cmd_vel", "geometry_msgs/Twist")
    session.drive(Velocity(0.5, 0.0), 3.0)
    assert session.close()
    assert not session.drive(Velocity(0.5, 0.0), 3.1)
    assert [one.linear.x for one in published(publisher)] == [0.5, 0.0]
    wait_until(lambda: publisher.unregister.called, lambda: "the publisher is left")
