"""Tests of the conversion of messages between types with other fields."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.message_definitions import parse
from ros2_bridge.types.codec_ops import ConversionError
from ros2_bridge.types.field_mapping import FieldMapping, MappingError, unassigned
from ros2_bridge.types.type_pair import FieldRules

SEPARATOR = "\n" + "=" * 80 + "\n"
#: A ROS 1 type, and a ROS 2 type with the same content in another order, with other names.
FIRST = parse(
    "a/Drive",
    "Header header\nfloat64 v\nstring name\nSide left\nSide[] all\nbool[2] old\nint32[2] pair"
    + SEPARATOR
    + "MSG: a/Side\nfloat32 speed\nstring[] notes\ntime at"
    + SEPARATOR
    + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id",
)
SECOND = parse(
    "b/Drive",
    "string label\nHeader header\nSide port\nfloat64 speed\nint32[2] pair\nSide[] all\nuint8 mode"
    + SEPARATOR
    + "MSG: b/Side\ntime at\nfloat32 speed\nuint16 id\nstring[] notes"
    + SEPARATOR
    + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id",
)
RULES = {
    "a/Drive": FieldRules(
        "b/Drive", {"v": "speed", "name": "label", "left": "port"}, ["old"], ["mode"]
    ),
    "a/Side": FieldRules("b/Side", {}, [], ["id"]),
}


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def texts(values):
    return struct.pack("<I", len(values)) + b"".join(map(text, values))


def default(datatype):
    """Return a message of zeros, but mode 7 and id 9."""
    if datatype == "b/Side":
        return bytes(12) + b"\x09\0" + bytes(4)
    header = struct.pack("<III", 0, 0, 0) + text("")
    side = bytes(8) + bytes(4) + b"\x09\0" + bytes(4)
    return text("") + header + side + bytes(8) + bytes(8) + bytes(4) + b"\7"


def mapping(rules=None):
    chosen = RULES if rules is None else rules
    return FieldMapping("a/Drive", FIRST, "b/Drive", SECOND, chosen, default)


SIDES = st.tuples(
    st.floats(width=32, allow_nan=False),
    st.lists(st.text(max_size=3), max_size=3),
    st.tuples(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1)),
)


@given(
    st.integers(0, 2**32 - 1),
    st.text(max_size=5),
    st.floats(allow_nan=False),
    SIDES,
    st.lists(SIDES, max_size=3),
    st.booleans(),
)
def test_fields_are_joined_in_the_other_order_and_back(seq, name, speed, left, sides, old):
    def side1(one):
        return struct.pack("<f", one[0]) + texts(one[1]) + struct.pack("<II", *one[2])

    def side2(one):
        return struct.pack("<IIfH", *one[2], one[0], 9) + texts(one[1])

    header = struct.pack("<III", seq, 5, 6) + text("base")
    count, pair = struct.pack("<I", len(sides)), struct.pack("<ii", -1, 2)
    start = header + struct.pack("<d", speed) + text(name) + side1(left)
    middle = count + b"".join(map(side1, sides))
    first = start + middle + bytes([old, old]) + pair
    second = text(name) + header + side2(left) + struct.pack("<d", speed) + pair
    second += count + b"".join(map(side2, sides)) + b"\7"
    assert mapping().to_second(first) == second
    assert mapping().to_first(second) == start + middle + bytes(2) + pair


@pytest.mark.parametrize("cut", [-1, -9, 3, 0])
def test_message_of_another_length_is_rejected(cut):
    first = bytes(12) + text("") + bytes(8) + text("") + bytes(16) + bytes(4) + bytes(10)
    assert mapping().to_second(first)
    for data in (first[:cut], first + b"\0"):
        with pytest.raises(ConversionError, match=f"{len(data)} bytes are not a message"):
            mapping().to_second(data)


def changed(**fields):
    rule = RULES["a/Drive"]._replace(**fields)
    return {**RULES, "a/Drive": rule}


@pytest.mark.parametrize(
    ("rules", "reason"),
    [
        ({}, "a/Drive: v has no counterpart v in b/Drive"),
        ({}, "b/Drive: mode has no counterpart in a/Drive"),
        (changed(left_out1=[]), "a/Drive: old has no counterpart old in b/Drive"),
        (changed(left_out2=[]), "b/Drive: mode has no counterpart in a/Drive"),
        (changed(left_out2=["mode", "pair"]), "b/Drive: pair is left out, but has a counterpart"),
        (changed(left_out1=["old", "left"]), "a/Drive: left is left out, but has a counterpart"),
        (changed(left_out2=["mode", "mod"]), "b/Drive has no field mod"),
        (changed(left_out1=["old", "older"]), "a/Drive has no field older"),
        (
            changed(counterparts={**RULES["a/Drive"].counterparts, "old": "mode", "x": "y"}),
            "a/Drive has no field x; b/Drive has no field y",
        ),
        (
            changed(counterparts={"v": "label", "name": "speed", "left": "port"}),
            "a/Drive: v and label of b/Drive have different types",
        ),
        (
            changed(counterparts={**RULES["a/Drive"].counterparts, "left": "all"}),
            "a/Drive: left.speed has no counterpart all.speed in b/Drive",
        ),
        ({"a/Drive": RULES["a/Drive"]}, "b/Side: id has no counterpart in a/Side"),
        (
            changed(counterparts={"v": "speed", "name": "label", "left": "port", "pair": "speed"}),
            "b/Drive: speed has several counterparts in a/Drive",
        ),
    ],
)
def test_rules_that_do_not_fit_are_rejected_with_each_reason(rules, reason):
    with pytest.raises(MappingError) as caught:
        mapping(rules)
    assert reason in str(caught.value)


def test_draft_names_the_fields_without_a_counterpart():
    found = unassigned("a/Drive", FIRST, "b/Drive", SECOND, {})
    missing1 = ["v", "name", "left.speed", "left.notes", "left.at", "old"]
    missing2 = ["label", "port.at", "port.speed", "port.id", "port.notes", "speed", "mode"]
    assert found == (missing1, missing2)
    assert unassigned("a/Drive", FIRST, "b/Drive", SECOND, RULES) == ([], [])


def test_upper_case_names_correspond_to_lower_case():
    first, second = parse("a/K", "float64[2] K\nstring R"), parse("b/K", "string r\nfloat64[2] k")
    converter = FieldMapping("a/K", first, "b/K", second, {}, default)
    data = struct.pack("<dd", 1.5, 2.5) + text("x")
    assert converter.to_second(data) == text("x") + struct.pack("<dd", 1.5, 2.5)
    assert converter.to_first(converter.to_second(data)) == data


def messages(text):
    """Return the definitions in a text such as ``a/A:B b,bool c | a/B:int8 i``."""
    first, *others = text.split(" | ")
    return parse(first.partition(":")[0], definition(first) + "".join(map(other_type, others)))


def definition(text):
    return text.partition(":")[2].replace(",", "\n")


def other_type(text):
    return SEPARATOR + f"MSG: {text.partition(':')[0]}\n" + definition(text)


def test_rule_has_no_effect_where_the_other_message_contains_another_type():
    first = messages("a/Path:Pose one,Pose[] all,int32 old | a/Pose:float64 x")
    rules = {
        "a/Path": FieldRules("b/Path", {}, ["old"]),
        "a/Pose": FieldRules("b/Transform", {"x": "y"}, [], ["z"]),
    }
    second = messages("b/Path:Pose one,Pose[] all | b/Pose:float64 x")
    data = struct.pack("<dI", 1.5, 1) + struct.pack("<dI", 2.5, 0)
    converter = FieldMapping("a/Path", first, "b/Path", second, rules, default)
    assert converter.to_second(data) == data[:-4]
    assert converter.to_first(data[:-4]) == data
    second = messages("b/Path:Transform one,Transform[] all | b/Transform:int32 z,float64 y")
    converter = FieldMapping("a/Path", first, "b/Path", second, rules, lambda _: bytes(16))
    moved = struct.pack("<idIid", 0, 1.5, 1, 0, 2.5)
    assert converter.to_second(data) == moved
    assert converter.to_first(moved) == data
    assert unassigned("a/Path", first, "b/Path", second, rules) == ([], [])


def test_rule_has_an_effect_on_one_of_two_fields_of_a_type_with_two_counterparts():
    first = messages("a/A:P[] one,P[] two | a/P:int8 x,int8 y")
    second = messages("b/A:P[] one,Q[] two | b/P:int8 y,int8 x | b/Q:int8 x,int8 z,int8 y")
    rules = {"a/P": FieldRules("b/Q", {}, [], ["z"])}
    converter = FieldMapping("a/A", first, "b/A", second, rules, lambda _: b"\0\7\0")
    count = struct.pack("<I", 1)
    data = count + b"\1\2" + count + b"\3\4"
    assert converter.to_second(data) == count + b"\2\1" + count + b"\3\7\4"
    assert converter.to_first(converter.to_second(data)) == data


def test_longest_path_in_the_rules_counts_before_those_of_nested_messages():
    first = messages("a/A:B b | a/B:C c,int8 i | a/C:int16 x,int32 y")
    second = messages("b/A:F f,E e | b/F:int8 i | b/E:int32 v,int16 u")
    rules = {
        "a/A": FieldRules("b/A", {"b": "f", "b.c": "e"}),
        "a/B": FieldRules("b/F", {"c": "nothing"}),
        "a/C": FieldRules("b/E", {"x": "u", "y": "v"}),
    }
    converter = FieldMapping("a/A", first, "b/A", second, rules, default)
    data = struct.pack("<hib", 1, 2, 3)
    assert converter.to_second(data) == struct.pack("<bih", 3, 2, 1)
    assert converter.to_first(converter.to_second(data)) == data


def test_rules_of_a_message_hold_at_any_depth():
    first = messages("a/A:B b | a/B:C c | a/C:int8 x")
    second = messages("b/A:B b | b/B:C c | b/C:int8 x,int8 y")
    rules = {"a/C": FieldRules("b/C", {}, [], ["y"])}
    converter = FieldMapping("a/A", first, "b/A", second, rules, lambda _: b"\0\7")
    assert converter.to_second(b"\1") == b"\1\7"


def test_arrays_of_a_fixed_length_are_part_of_each_message():
    first = messages("a/A:B[] all,int8 end | a/B:int16[2] x,int8 y")
    second = messages("b/A:int8 end,B[] all | b/B:int16[2] x,int8 y")
    converter = FieldMapping("a/A", first, "b/A", second, {}, default)
    several, end = struct.pack("<I", 2) + bytes(range(10)), b"\x7f"
    assert converter.to_second(several + end) == end + several
    assert converter.to_first(end + several) == several + end
    first = messages("a/C:D[2] all | a/D:int8 x,int8 z")
    second = messages("b/C:D[2] all | b/D:int8 z,int8 y")
    rules = {"a/D": FieldRules("b/D", {"x": "y"})}
    converter = FieldMapping("a/C", first, "b/C", second, rules, default)
    assert converter.to_second(b"\1\2\3\4") == converter.to_first(b"\1\2\3\4") == b"\2\1\4\3"


def test_each_of_several_messages_without_fields_gets_its_defaults():
    first, second = messages("a/A:N[] all | a/N:"), messages("b/A:N[] all | b/N:int16 id")
    rules = {"a/N": FieldRules("b/N", {}, [], ["id"])}
    converter = FieldMapping("a/A", first, "b/A", second, rules, lambda _: b"\7\0")
    count = struct.pack("<I", 2)
    assert converter.to_second(count) == count + b"\7\0\7\0"
    assert converter.to_first(count + b"\7\0\7\0") == count


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        *[("int32", "uint32"), ("int8", "uint8"), ("uint8", "bool"), ("time", "int64")],
        *[("int32[2]", "int32[]"), ("int32[2]", "int32[3]"), ("int32", "int32[]")],
    ],
)
def test_type_that_would_change_values_is_rejected(ours, theirs):
    first, second = parse("a/N", f"{ours} n"), parse("b/N", f"{theirs} n")
    with pytest.raises(MappingError, match="a/N: n and n of b/N have different types"):
        FieldMapping("a/N", first, "b/N", second, {}, default)


@pytest.mark.parametrize(("ours", "theirs"), [("char", "uint8"), ("int8", "byte")])
def test_other_name_of_a_type_is_accepted(ours, theirs):
    first, second = parse("a/N", f"{ours} n"), parse("b/N", f"{theirs} n")
    assert FieldMapping("a/N", first, "b/N", second, {}, default).to_second(b"\x07") == b"\x07"
