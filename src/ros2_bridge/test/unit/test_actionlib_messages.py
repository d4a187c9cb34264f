"""Goals and their reports as bytes, compared with actionlib's own messages."""

import io
from typing import Any

import actionlib.msg as of_actionlib
import pytest
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from std_msgs.msg import Header

from ros2_bridge.action_bridge import actionlib_messages
from ros2_bridge.action_bridge.actionlib_messages import GoalReport
from ros2_bridge.types.codec import ConversionError

HEADER = Header(3, rospy.Time(9, 8), "map")
ID = GoalID(rospy.Time(5, 7), "/arm-1-5.7")
STAMP = 5_000_000_007
REPORT = GoalReport("/arm-1-5.7", STAMP, GoalStatus.ABORTED, "it sticks", b"\4\0\0\0")


class Raw:
    """Message of bytes, as a topic of any type has it."""

    _buff = b""


def content(message: Any) -> bytes:
    out = io.BytesIO()
    message.serialize(out)
    return out.getvalue()


@pytest.fixture(autouse=True)
def now(monkeypatch: "pytest.MonkeyPatch") -> None:
    """Give ROS a time without a node."""
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(11, 12))


def test_goal_is_that_of_actionlib() -> None:
    data = content(of_actionlib.TestActionGoal(HEADER, ID, of_actionlib.TestGoal(4)))
    assert actionlib_messages.read_goal(data) == ("/arm-1-5.7", STAMP, b"\4\0\0\0")
    sent = actionlib_messages.write_goal(Raw, "/arm-1-5.7", STAMP, b"\4\0\0\0")
    goal = of_actionlib.TestActionGoal().deserialize(sent._buff)
    assert (goal.goal_id, goal.goal.goal, goal.header.stamp) == (ID, 4, rospy.Time(11, 12))


def test_report_is_that_of_actionlib() -> None:
    status = GoalStatus(ID, GoalStatus.ABORTED, "it sticks")
    data = content(of_actionlib.TestActionResult(HEADER, status, of_actionlib.TestResult(4)))
    assert actionlib_messages.read_report(data) == REPORT
    result = of_actionlib.TestActionResult().deserialize(
        actionlib_messages.write_report(Raw, REPORT)._buff
    )
    assert (result.status, result.result.result) == (status, 4)


@pytest.mark.parametrize("length", [0, 12, 20, 40])
def test_part_of_a_message_is_refused(length: int) -> None:
    data = content(
        of_actionlib.TestActionResult(
            HEADER, GoalStatus(ID, 4, "it sticks"), of_actionlib.TestResult(4)
        )
    )
    for read in (actionlib_messages.read_goal, actionlib_messages.read_report):
        with pytest.raises(ConversionError):
            read(data[:length])


def test_list_of_goals_is_that_of_actionlib() -> None:
    listed = actionlib_messages.write_statuses([REPORT])
    array = GoalStatusArray().deserialize(content(listed))
    (one,) = array.status_list
    assert (array.header.stamp, one.goal_id) == (rospy.Time(11, 12), ID)
    assert (one.status, one.text) == (GoalStatus.ABORTED, "it sticks")
    assert actionlib_messages.read_statuses(array) == [("/arm-1-5.7", STAMP, GoalStatus.ABORTED)]
