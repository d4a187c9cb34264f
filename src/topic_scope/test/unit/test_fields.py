"""Names of fields, their resolution in a message, and their values."""

import io
import math
from typing import Any, List

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosgraph_msgs.msg import Log, TopicStatistics
from sensor_msgs.msg import JointState
from std_msgs.msg import Float32, Float64MultiArray, Header, MultiArrayDimension, String

from topic_scope.messages import arrays, decoding, fields
from topic_scope.messages.message_layout import (
    Array,
    DefinitionError,
    MessageLayout,
    layout_of,
    parse,
)

NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)


def wire(message: object) -> bytes:
    """Return a serialized message."""
    buffer = io.BytesIO()
    message.serialize(buffer)  # type: ignore[attr-defined]
    return buffer.getvalue()


def texts(found: List[fields.NumericField]) -> List[str]:
    return [fields.to_text(field.path) for field in found]


def test_colons_expand_to_several_fields() -> None:
    assert fields.expand("/pose/position/x:y:z") == [
        "/pose/position/x",
        "/pose/position/y",
        "/pose/position/z",
    ]


def test_a_name_becomes_global() -> None:
    assert fields.expand("signal/signal_y") == ["/signal/signal_y"]


@pytest.mark.parametrize(
    "name",
    [
        "",
        "/",
        "//a",
        "/a/",
        "/a//b",
        "/a:",
        "/a[]",
        "/a[-1]",
        "/a[1x]",
        "/a[b c]",
        "/a[b",
        "/a b",
        "/a\n",
        "/../a",
        "a" * 400,
    ],
)
def test_invalid_name_is_rejected(name: str) -> None:
    with pytest.raises(fields.FieldError):
        fields.expand(name)


@settings(max_examples=30)
@given(st.lists(NAMES, min_size=1, max_size=4), st.lists(NAMES, max_size=3))
def test_the_longest_topic_is_taken(topic: List[str], rest: List[str]) -> None:
    name = "/" + "/".join(topic)
    topics = ["/" + "/".join(topic[:end]) for end in range(1, len(topic) + 1)]
    assert fields.split("/".join([name] + rest), topics) == (name, "/".join(rest))


def test_name_without_a_topic_denotes_nothing() -> None:
    assert fields.split("/signal/signal_y", ["/sig", "/signal/signal_y/more"]) is None


@settings(max_examples=30)
@given(st.lists(st.tuples(NAMES, st.lists(st.integers(0, 999), max_size=2)), max_size=4))
def test_path_and_text_are_the_same(parts: List[tuple]) -> None:
    path = tuple(item for name, indices in parts for item in (name, *indices))
    assert fields.to_path(fields.to_text(path)) == path


def test_message_denotes_all_of_its_numbers() -> None:
    found = fields.resolve(layout_of(Header), "")
    assert found == [(("seq",), "uint32"), (("stamp",), "time")]


def test_nested_fields_and_arrays_are_listed() -> None:
    message = Float64MultiArray(data=[1.0, 2.0])
    message.layout.dim = [MultiArrayDimension("rows", 2, 2)]
    lengths = arrays.lengths_in(layout_of(Float64MultiArray), wire(message))
    found = fields.numeric_fields(layout_of(Float64MultiArray), lengths)
    assert texts(found) == [
        "layout/dim[0]/size",
        "layout/dim[0]/stride",
        "layout/data_offset",
        "data[0]",
        "data[1]",
    ]


def test_array_of_unknown_length_has_one_element() -> None:
    assert "data[0]" in texts(fields.numeric_fields(layout_of(Float64MultiArray)))


def test_long_arrays_list_only_their_first_elements() -> None:
    layout = parse("a/A", "float32[1000000] x")
    assert len(fields.numeric_fields(layout)) == fields.LISTED_ELEMENTS
    assert texts(fields.resolve(layout, "x[999999]")) == ["x[999999]"]


@pytest.mark.parametrize("text", ["missing", "data/x", "data[0]", "data/"])
def test_missing_field_is_rejected(text: str) -> None:
    with pytest.raises(fields.FieldError):
        fields.resolve(layout_of(Float32), text)


def test_text_is_not_a_number() -> None:
    with pytest.raises(fields.FieldError, match="no number"):
        fields.resolve(layout_of(String), "data")
    with pytest.raises(fields.FieldError):
        decoding.Decoder(layout_of(String), ("data",))


def test_element_after_the_end_of_a_fixed_array_is_rejected() -> None:
    layout = parse("a/A", "float32[3] x")
    with pytest.raises(fields.FieldError, match="3 elements"):
        fields.resolve(layout, "x[3]")


def log(names: List[str], level: int = 4) -> Log:
    message = Log(level=level, name="näme", msg="text", line=77, topics=names)
    message.header.stamp.secs, message.header.stamp.nsecs = 12, 500000000
    message.header.frame_id = "frame"
    return message


def value_in(message: Any, path: fields.Path) -> float:
    """Return the value at a path of a message object, without names of elements."""
    for part in path:
        message = message[part] if isinstance(part, int) else getattr(message, part)
    return float(message.to_sec() if hasattr(message, "to_sec") else message)


def test_decoded_value_equals_the_message_field() -> None:
    layout, messages = layout_of(Log), [log(["/a", "/bcd"]), log([], level=8)]
    for field in fields.numeric_fields(layout):
        values = [value_in(message, field.path) for message in messages]
        decoder = decoding.Decoder(layout, field.path)
        assert decoder.decode([wire(message) for message in messages]).tolist() == values
    stamp = decoding.Decoder(layout, ("header", "stamp"))
    assert stamp.decode([wire(messages[0])]).tolist() == [12.5]
    assert (stamp.value(wire(messages[0])), stamp.is_time) == (12500000000, True)


@settings(max_examples=30)
@given(st.lists(st.lists(st.floats(width=64), max_size=5), min_size=1, max_size=5))
def test_elements_after_a_text_are_read(rows: List[List[float]]) -> None:
    messages = [Float64MultiArray(data=row) for row in rows]
    for message, row in zip(messages, rows):
        message.layout.dim = [MultiArrayDimension("x" * len(row), 1, 1)] * len(row)
    decoder = decoding.Decoder(layout_of(Float64MultiArray), ("data", 1))
    values = decoder.decode([wire(message) for message in messages]).tolist()
    expected = [row[1] if len(row) > 1 else math.nan for row in rows]
    assert [repr(value) for value in values] == [repr(value) for value in expected]


def test_numbers_of_all_types_are_read() -> None:
    layout = parse(
        "a/All",
        "bool a\nint8 b\nuint8 c\nint16 d # text\nuint16 e\nint32 f\nuint32 g\nint64 h\nuint64 i\n"
        "float32 j\nfloat64 k\ntime l\nduration m\nint32 N=5\nstring O=a = b # c\n",
    )
    data = (
        b"\x01\xff\xff\xfe\xff\xfe\xff"
        + b"\xfd\xff\xff\xff" * 2
        + b"\xfc"
        + b"\xff" * 7
        + b"\x02"
        + bytes(7)
        + b"\x00\x00\x00\x3f"
        + bytes(6)
        + b"\xf0\xbf"
        + b"\x03\x00\x00\x00\x00\x65\xcd\x1d"
        + b"\xff\xff\xff\xff\x00\x65\xcd\x1d"
    )
    expected = [1, -1, 255, -2, 65534, -3, 2**32 - 3, -4, 2, 0.5, -1.0, 3.5, -0.5]
    found = fields.numeric_fields(layout)
    values = [decoding.Decoder(layout, field.path).decode([data, data]) for field in found]
    assert [value.tolist() for value in values] == [[number] * 2 for number in expected]


def test_data_after_an_array_are_not_its_elements() -> None:
    decoder = decoding.Decoder(parse("a/A", "uint8[] x\nuint8 y"), ("x", 1))
    values = decoder.decode([b"\x01\x00\x00\x00\x07\x08", b"\x02\x00\x00\x00\x07\x08\x09"])
    assert [repr(value) for value in values.tolist()] == ["nan", "8.0"]


@settings(max_examples=30)
@given(st.binary(max_size=200))
def test_garbage_is_nan_and_not_an_error(data: bytes) -> None:
    for message_class in (Log, TopicStatistics, Float64MultiArray):
        layout = layout_of(message_class)
        for field in fields.numeric_fields(layout, arrays.lengths_in(layout, data)):
            assert decoding.Decoder(layout, field.path).decode([data]).shape == (1,)


@pytest.mark.parametrize(
    "text",
    [
        "float32",
        "float32 a b",
        "thing x",
        "a/A x",
        "float32[x] y",
        "b/B x\n" + "=" * 80 + "\nMSG: b/B\na/A y",
        "b/B x\n" + "=" * 80 + "\nfloat32 y",
        "import os",
    ],
)
def test_malformed_definition_is_rejected(text: str) -> None:
    with pytest.raises(DefinitionError):
        parse("a/A", text)


def test_recursive_definition_is_rejected() -> None:
    parts = ["a/T0 x"]
    parts += [f"MSG: a/T{n}\na/T{n + 1} x\na/T{n + 1} y" for n in range(18)]
    parts += ["MSG: a/T18\nfloat32 x"]
    with pytest.raises(DefinitionError, match="too many"):
        parse("a/A", ("\n" + "=" * 80 + "\n").join(parts))


def test_sizes_are_known_where_they_are_fixed() -> None:
    layout = parse("a/A", "float32[4] x\nstring[] y\nuint8[] z\nstring[0] w")
    assert isinstance(layout, MessageLayout) and layout.size is None
    sizes = [field.size for _, field in layout.fields if isinstance(field, Array)]
    assert sizes == [16, None, None, 0]


def joints(names: List[str], positions: List[float]) -> JointState:
    return JointState(name=names, position=positions, header=Header(frame_id="x" * len(names)))


def test_element_is_found_by_name_at_any_index() -> None:
    layout = layout_of(JointState)
    path = fields.to_path("position[left-wheel_1]")
    assert fields.to_text(path) == "position[left-wheel_1]"
    messages = [
        joints(["arm", "left-wheel_1"], [1.0, 2.0]),
        joints(["left-wheel_1", "arm"], [3.0, 4.0]),
        joints(["arm"], [5.0]),
        joints(["arm", "left-wheel_1"], [6.0]),  # a name without a position
        joints([], []),
    ]
    expected = ["2.0", "3.0", "nan", "nan", "nan"]
    decoded = decoding.Decoder(layout, path).decode([wire(one) for one in messages])
    assert [repr(value) for value in decoded.tolist()] == expected
    whole = wire(messages[0])
    for end in range(len(whole)):  # cut off anywhere
        decoding.Decoder(layout, path).decode([whole[:end]])


def test_elements_without_names_have_numbers_only() -> None:
    with pytest.raises(fields.FieldError, match="the elements of data have no names"):
        fields.resolve(layout_of(Float64MultiArray), "data[arm]")
    with pytest.raises(fields.FieldError, match="frame_id is not an array|no names"):
        fields.resolve(layout_of(JointState), "header/frame_id[arm]")
    assert fields.resolve(layout_of(JointState), "effort[arm]") == [
        (("effort", fields.Key("arm")), "float64")
    ]
