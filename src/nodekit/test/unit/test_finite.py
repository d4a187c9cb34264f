"""Tests of the check for finite messages."""

import io
import math
import struct

import genpy
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosgraph_msgs.msg import Log
from std_msgs.msg import (
    ByteMultiArray,
    ColorRGBA,
    Empty,
    Float32,
    Float32MultiArray,
    Float64,
    Float64MultiArray,
    Header,
    Int32,
    MultiArrayDimension,
    MultiArrayLayout,
    String,
    Time,
    UInt8MultiArray,
)

from nodekit.messaging.finite import LARGEST_FLOAT32, is_finite, to_float32

FINITE = st.floats(allow_nan=False, allow_infinity=False)
NOT_FINITE = st.sampled_from([math.nan, -math.nan, math.inf, -math.inf])
#: Numbers that a float32 field can carry.
FLOATS32 = st.floats(-LARGEST_FLOAT32, LARGEST_FLOAT32, allow_nan=False)
HEADERS = st.builds(
    Header,
    seq=st.integers(0, 2**32 - 1),
    stamp=st.builds(genpy.Time, st.integers(0, 2**31), st.integers(0, 10**9 - 1)),
    frame_id=st.text(),
)


class Nested(genpy.Message):
    """A message as genpy makes them, with a header, another message and a list of messages."""

    _type = "test/Nested"
    __slots__ = ["header", "color", "colors", "value"]
    _slot_types = ["std_msgs/Header", "std_msgs/ColorRGBA", "std_msgs/ColorRGBA[]", "float64"]

    def __init__(self, header=None, color=None, colors=(), value=0.0):
        self.header = header or Header()
        self.color = color or ColorRGBA()
        self.colors = list(colors)
        self.value = value


COLORS = st.builds(ColorRGBA, FINITE, FINITE, FINITE, FINITE)


@pytest.mark.parametrize(
    "message",
    [
        Empty(),
        String("nan"),
        String("inf" * 1000),
        Int32(-(2**31)),
        Time(genpy.Time(2**32 - 1, 999999999)),
        Header(7, genpy.Time(1, 2), "-inf"),
        Log(header=Header(), level=8, name="/n", msg="NaN", topics=["/inf", "/nan"]),
        Float64(1.7976931348623157e308),
        Float32(5e-324),
        Float64(3),
        ByteMultiArray(data=[-128, 127]),
        UInt8MultiArray(data=b"\x00\x7f\xc0\xff"),
        Float64MultiArray(),
        Float64MultiArray(MultiArrayLayout([MultiArrayDimension("inf", 3, 3)], 0), [1.0, 2.0, 3.0]),
    ],
)
def test_message_without_floats_is_finite(message):
    assert is_finite(message) is True


@given(FINITE, NOT_FINITE)
def test_a_field(finite, other):
    assert is_finite(Float64(finite)) is True
    assert is_finite(Float64(other)) is False


@given(
    st.lists(FINITE, max_size=20), NOT_FINITE, st.integers(0, 20), st.sampled_from([list, tuple])
)
def test_non_finite_number_at_any_position_of_a_list(numbers, other, place, kind):
    assert is_finite(Float64MultiArray(data=kind(numbers))) is True
    numbers.insert(place, other)
    assert is_finite(Float64MultiArray(data=kind(numbers))) is False


@given(HEADERS, st.builds(ColorRGBA, FINITE, FINITE, FINITE, FINITE), st.lists(COLORS), FINITE)
def test_messages_in_a_message(header, color, colors, value):
    assert is_finite(Nested(header, color, colors, value)) is True


@given(st.lists(COLORS, max_size=3), NOT_FINITE, st.sampled_from("rgba"), st.integers(0, 3))
def test_one_number_deep_in_a_message_is_enough(colors, other, channel, place):
    wrong = ColorRGBA()
    setattr(wrong, channel, other)
    assert is_finite(Nested(color=wrong, colors=colors)) is False
    assert is_finite(Nested(value=other, colors=colors)) is False
    colors.insert(place, wrong)
    assert is_finite(Nested(colors=colors)) is False
    assert is_finite(Nested(colors=[ColorRGBA()])) is True, "the last answer is not remembered"


@given(st.lists(st.floats(width=32), max_size=10))
def test_received_message_is_checked_like_sent_one(numbers):
    finite = all(math.isfinite(number) for number in numbers)
    for data_class, letter in ((Float32MultiArray, "f"), (Float64MultiArray, "d")):
        body = struct.pack(f"<3I{len(numbers)}{letter}", 0, 0, len(numbers), *numbers)
        assert is_finite(data_class().deserialize(body)) is finite
        assert is_finite(data_class(data=numbers)) is finite


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_numpy_arrays_are_checked(dtype):
    numpy = pytest.importorskip("numpy")
    numbers = numpy.array([1.0, 2.0], dtype)
    assert is_finite(Float64MultiArray(data=numbers))
    assert is_finite(Float64(numbers[0]))
    numbers[1] = math.inf
    assert not is_finite(Float64MultiArray(data=numbers))
    assert not is_finite(Float64(numbers[1]))


@given(FLOATS32)
def test_float32_is_rounded_as_in_a_message(value):
    carried = to_float32(value)
    sent = Float32(value)
    assert carried == Float32().deserialize(serialized(sent)).data
    assert to_float32(carried) == carried
    assert math.copysign(1.0, carried) == math.copysign(1.0, value)
    assert abs(carried - value) <= max(abs(value) * 2.0**-24, 2.0**-150)


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_float32_stays_as_it_is(value):
    assert to_float32(value) == value


def test_the_largest_float32_is_accepted_and_larger_values_are_not():
    (largest,) = struct.unpack("<f", b"\xff\xff\x7f\x7f")
    assert LARGEST_FLOAT32 == largest
    for sign in (1.0, -1.0):
        assert to_float32(sign * LARGEST_FLOAT32) == sign * LARGEST_FLOAT32
        with pytest.raises(OverflowError):
            to_float32(sign * LARGEST_FLOAT32 * (1.0 + 2.0**-24))


def serialized(message):
    """Return a serialized message, without its length."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()
