"""The messages of an action in ROS 1: what actionlib puts before what the user has defined."""

import io
from typing import Any, List, NamedTuple, Tuple

import rospy

from ros2_bridge.actions.states import Status1
from ros2_bridge.environment.ros1_messages import GoalID, GoalStatus, GoalStatusArray, Header


class Reported(NamedTuple):
    """A message of a server about a goal.

    :param text: the goal's id
    :param stamp: when the goal began, ns
    :param why: text of its status
    :param content: feedback or result
    """

    text: str
    stamp: int
    status: Status1
    why: str
    content: bytes


def goal_id(text: str, stamp: int) -> Any:
    """Return an id, with when the goal began, ns."""
    return GoalID(rospy.Time(*divmod(stamp, 10**9)), text)


def read_goal(data: bytes) -> Tuple[str, int, bytes]:
    """Return a goal's id, when it began, ns, and the goal."""
    name, content = _split(data, GoalID())
    return name.id, name.stamp.to_nsec(), content


def write_goal(raw: Any, text: str, stamp: int, content: bytes) -> Any:
    """Return the message that sends a goal.

    :param raw: class of the message
    """
    return _joined(raw, goal_id(text, stamp), content)


def read_report(data: bytes) -> Reported:
    """Return what a message with feedback or with a result says."""
    status, content = _split(data, GoalStatus())
    return Reported(
        status.goal_id.id,
        status.goal_id.stamp.to_nsec(),
        Status1(status.status),
        status.text,
        content,
    )


def write_report(raw: Any, report: Reported) -> Any:
    """Return the message with feedback or a result.

    :param raw: class of the message
    """
    return _joined(raw, _status(report), report.content)


def read_statuses(message: Any) -> List[Tuple[str, int, Status1]]:
    """Return id, stamp in ns, and status of each goal of a list; without unknown statuses."""
    return [
        (one.goal_id.id, one.goal_id.stamp.to_nsec(), Status1(one.status))
        for one in message.status_list
        if one.status in set(Status1)
    ]


def write_statuses(reports: List[Reported]) -> Any:
    """Return the list of goals."""
    header = Header(stamp=rospy.Time.now())
    return GoalStatusArray(header, [_status(report) for report in reports])


def _status(report: Reported) -> Any:
    return GoalStatus(goal_id(report.text, report.stamp), int(report.status), report.why)


def _split(data: bytes, part: Any) -> Tuple[Any, bytes]:
    """Return what stands behind the header, and the rest."""
    header, rest = Header(), data
    for one in (header, part):
        one.deserialize(rest)
        rest = rest[len(_bytes(one)) :]
    return part, rest


def _joined(raw: Any, part: Any, content: bytes) -> Any:
    message = raw()
    message._buff = _bytes(Header(stamp=rospy.Time.now())) + _bytes(part) + content
    return message


def _bytes(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()
