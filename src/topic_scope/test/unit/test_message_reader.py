"""Reader of whole messages against the generated classes, and its errors."""

import io
from typing import Any

import numpy
import pytest
from geometry_msgs.msg import Point
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState, LaserScan
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from topic_scope.messages.message_layout import layout_of, parse
from topic_scope.messages.message_reader import TruncatedMessage, MessageReader


def serialized(message: Any) -> bytes:
    file = io.BytesIO()
    message.serialize(file)
    return file.getvalue()


def same(read: Any, message: Any) -> bool:
    """Return whether a message was read correctly."""
    if isinstance(read, dict):
        return all(same(value, getattr(message, name)) for name, value in read.items())
    if hasattr(message, "to_sec"):
        return bool(abs(read - message.to_sec()) < 1e-6)
    if isinstance(read, (list, numpy.ndarray)):
        return len(read) == len(message) and all(map(same, read, message))
    return bool(read == message)


def messages() -> Any:
    odometry = Odometry(child_frame_id="base")
    odometry.header.stamp.secs, odometry.header.stamp.nsecs = 7, 500000000
    odometry.pose.covariance[35] = 2.5
    scan = LaserScan(range_max=3.5, ranges=[1.0, 2.0], intensities=[])
    names = JointState(name=["left", "ü"], position=[0.5, -0.5])
    marker = Marker(ns="walls", id=-3, points=[Point(1.0, 2.0, 3.0)], text="a", frame_locked=True)
    return [odometry, scan, names, MarkerArray([marker, Marker()]), TFMessage()]


@pytest.mark.parametrize("message", messages(), ids=lambda message: type(message).__name__)
def test_reads_what_was_written(message: Any) -> None:
    read = MessageReader(layout_of(type(message))).read(serialized(message))
    assert set(read) == set(message.__slots__) and same(read, message)


@settings(max_examples=30)
@given(st.sampled_from(messages()), st.data())
def test_truncated_or_corrupt_message_is_rejected_cheaply(message: Any, data: Any) -> None:
    reader, whole = MessageReader(layout_of(type(message))), serialized(message)
    end = data.draw(st.integers(0, len(whole) - 1))
    with pytest.raises(TruncatedMessage):
        reader.read(whole[:end])
    wrong = whole[:end] + data.draw(st.binary(min_size=1, max_size=8)) + whole[end + 8 :]
    try:
        reader.read(wrong)
    except TruncatedMessage:
        pass


def test_unbounded_count_of_empty_elements_is_rejected() -> None:
    separator = "\n" + "=" * 80 + "\n"
    layout = parse("a/B", f"Empty[] all{separator}MSG: a/Empty\n")
    with pytest.raises(TruncatedMessage):
        MessageReader(layout).read(b"\xff\xff\xff\xff")
