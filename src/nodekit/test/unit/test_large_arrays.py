"""Tests of messages with one large array of bytes, compared with genpy."""

import io
import struct

import pytest
import rospy
from hypothesis import given
from hypothesis import strategies as st
from std_msgs.msg import MultiArrayDimension, MultiArrayLayout, String, UInt8MultiArray

from nodekit.rospy_internals import large_arrays
from nodekit.rospy_internals.large_arrays import LEAST_BYTES, split, with_views, without_views

LABELS = st.text(st.characters(blacklist_categories=["Cs"]), max_size=5)


def serialized(message):
    """Return a message as genpy serializes it, with its length."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return struct.pack("<I", len(buffer.getvalue())) + buffer.getvalue()


@st.composite
def messages(draw):
    """Draw a message with a large array."""
    dimensions = [MultiArrayDimension(draw(LABELS), 1, 2) for _ in range(draw(st.integers(0, 3)))]
    data = draw(st.binary(max_size=100)) + bytes(LEAST_BYTES)
    array = draw(st.sampled_from([bytes, bytearray, memoryview]))(data)
    return UInt8MultiArray(MultiArrayLayout(dimensions, draw(st.integers(0, 9))), array)


@given(messages())
def test_split_message_equals_the_serialized_one_and_round_trips(message):
    parts = split(message, serialized)
    assert parts.joined() == serialized(without_views(message))
    assert len(parts) == len(parts.joined())
    assert parts.array is message.data
    copy = UInt8MultiArray()
    parts.body().fill(copy)
    assert copy == UInt8MultiArray(message.layout, bytes(message.data))
    assert type(copy.data) is bytes
    whole = rospy.AnyMsg()
    parts.body().fill(whole)
    assert whole._buff == serialized(without_views(message))[4:]


@pytest.mark.parametrize(
    "message",
    [
        UInt8MultiArray(data=bytes(LEAST_BYTES - 1)),
        UInt8MultiArray(data=[1] * LEAST_BYTES),
        String("x" * LEAST_BYTES),
        UInt8MultiArray(),
        UInt8MultiArray(data=memoryview(bytes(2 * LEAST_BYTES))[::2]),
    ],
    ids=["small", "list", "text", "empty", "every second byte"],
)
def test_message_without_a_large_array_of_bytes_is_not_split(message):
    assert split(message, serialized) is None


def test_message_that_contains_the_placeholder_is_not_split(monkeypatch):
    monkeypatch.setattr(large_arrays, "_PLACEHOLDER", b"0123456789abcdef")
    layout = MultiArrayLayout([MultiArrayDimension("0123456789abcdef", 1, 2)], 0)
    assert split(UInt8MultiArray(layout, bytes(LEAST_BYTES)), serialized) is None


def test_views_are_read_only_and_of_a_copy_of_the_message():
    message = UInt8MultiArray(data=bytearray(b"abc"))
    viewed = with_views(message)
    assert viewed is not message and message.data == bytearray(b"abc")
    assert viewed.data == b"abc" and viewed.data.readonly
    assert with_views(viewed) is viewed
    owned = without_views(viewed)
    assert type(owned.data) is bytes and owned.data == b"abc"
    assert without_views(owned) is owned
    text = String("abc")
    assert with_views(text) is text


def test_only_views_of_bytes_are_converted():
    part = without_views(UInt8MultiArray(data=memoryview(b"abcd")[::2]))
    assert part.data == b"ac" and type(part.data) is bytes
    numbers = UInt8MultiArray(data=memoryview(b"abcd").cast("H"))
    assert without_views(numbers) is numbers
