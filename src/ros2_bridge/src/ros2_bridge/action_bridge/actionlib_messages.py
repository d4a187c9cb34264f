"""Parser and builder of serialized actionlib messages; goal, feedback and result stay bytes."""

import io
import struct
from typing import Any, List, NamedTuple, Tuple

import rospy

from ros2_bridge.environment.ros1_messages import GoalID, GoalStatus, GoalStatusArray, Header
from ros2_bridge.types.codec import ConversionError

_STAMP, _LENGTH = struct.Struct("<II"), struct.Struct("<I")
#: Size of a Header before its string [bytes].
_HEADER = 12


class GoalReport(NamedTuple):
    """Feedback or result of a goal.

    :param text: the goal's id
    :param stamp: the goal's start time [ns]
    :param status: status number, possibly unknown
    :param why: text of the status
    :param content: feedback or result
    """

    text: str
    stamp: int
    status: int
    why: str
    content: bytes


def goal_id(text: str, stamp: int) -> Any:
    """Return a GoalID with the goal's start time [ns]."""
    return GoalID(rospy.Time(*divmod(stamp, 10**9)), text)


def read_goal(data: bytes) -> Tuple[str, int, bytes]:
    """Return a goal's id, its start time [ns], and the goal.

    :raises ConversionError: if it is invalid
    """
    try:
        text, stamp, at = _goal_id(data)
    except struct.error as error:
        raise ConversionError(str(error)) from None
    return text, stamp, data[at:]


def write_goal(raw: Any, text: str, stamp: int, content: bytes) -> Any:
    """Return the message that sends a goal.

    :param raw: class of the message
    """
    return _joined(raw, goal_id(text, stamp), content)


def read_report(data: bytes) -> GoalReport:
    """Parse a feedback or result message.

    :raises ConversionError: if it is invalid
    """
    try:
        text, stamp, at = _goal_id(data)
        why, end = _text(data, at + 1)
    except struct.error as error:
        raise ConversionError(str(error)) from None
    return GoalReport(text, stamp, data[at], why, data[end:])


def write_report(raw: Any, report: GoalReport) -> Any:
    """Return a feedback or result message.

    :param raw: class of the message
    """
    return _joined(raw, _status(report), report.content)


def read_statuses(message: Any) -> List[Tuple[str, int, int]]:
    """Return id, stamp [ns], and status number of each goal in a list."""
    return [
        (one.goal_id.id, one.goal_id.stamp.to_nsec(), one.status) for one in message.status_list
    ]


def write_statuses(reports: List[GoalReport]) -> Any:
    """Return the status list of these goals."""
    header = Header(stamp=rospy.Time.now())
    return GoalStatusArray(header, [_status(report) for report in reports])


def _status(report: GoalReport) -> Any:
    return GoalStatus(goal_id(report.text, report.stamp), report.status, report.why)


# Byte by byte: genpy replaces invalid UTF-8, and so loses the original length.
def _text(data: bytes, at: int) -> Tuple[str, int]:
    """Return the string at an offset, and the offset behind it."""
    (size,) = _LENGTH.unpack_from(data, at)
    end = at + _LENGTH.size + size
    if end > len(data):
        raise ConversionError(f"{size} bytes announced, {len(data) - at} left")
    return data[at + _LENGTH.size : end].decode("utf-8", "rosmsg"), end


def _goal_id(data: bytes) -> Tuple[str, int, int]:
    """Return the goal id behind a header, its stamp [ns], and the offset behind both."""
    _, at = _text(data, _HEADER)
    seconds, rest = _STAMP.unpack_from(data, at)
    text, end = _text(data, at + _STAMP.size)
    return text, seconds * 10**9 + rest, end


def _joined(raw: Any, part: Any, content: bytes) -> Any:
    message = raw()
    message._buff = _bytes(Header(stamp=rospy.Time.now())) + _bytes(part) + content
    return message


def _bytes(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()
