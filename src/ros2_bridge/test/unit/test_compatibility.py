"""Messages about a type that differs from its twin."""

from typing import Dict, Optional

import pytest

from nodekit.message_definitions import parse
from ros2_bridge.types.compatibility import difference, in_ros1_terms

SEPARATOR = "\n" + "=" * 80 + "\n"
HEADER = SEPARATOR + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
ROS2 = {
    "std_msgs/Header": {"stamp": "builtin_interfaces/Time", "frame_id": "string"},
    "pkg/Inner": {"x": "double"},
    "string_msgs/Inner": {"x": "double"},
    "builtin_interfaces/Time": {"sec": "int32", "nanosec": "uint32"},
}


def difference_of(text: str, other: Dict[str, str]) -> Optional[str]:
    fields = parse("pkg/a", text + HEADER + SEPARATOR + "MSG: pkg/Inner\nfloat64 x\n")
    return difference("pkg/a", fields, "pkg/A", lambda name: {"pkg/A": other, **ROS2}[name])


@pytest.mark.parametrize(
    "text, other",
    [
        ("", {}),
        ("Header header", {"header": "std_msgs/Header"}),
        ("float64[9] K", {"k": "double[9]"}),
        ("bool[] a\nbyte b\nchar c", {"a": "sequence<boolean>", "b": "octet", "c": "uint8"}),
        ("uint16 a\nint32 b\nuint64 c", {"a": "uint16", "b": "int32", "c": "uint64"}),
        ("string[] a", {"a": "sequence<string<20>, 5>"}),
        ("Inner a", {"a": "string_msgs/Inner"}),
        ("Inner[2] a\nInner[] b", {"a": "pkg/Inner[2]", "b": "sequence<pkg/Inner>"}),
        (
            "time a\nduration b",
            {"a": "builtin_interfaces/Time", "b": "builtin_interfaces/Duration"},
        ),
    ],
)
def test_the_same(text: str, other: Dict[str, str]) -> None:
    assert difference_of(text, other) is None


@pytest.mark.parametrize(
    "text, other, sentence",
    [
        ("uint8 a", {"b": "uint8"}, "pkg/a has field a in ROS 1 but pkg/A has b in ROS 2"),
        ("uint8 a", {"a": "uint16"}, "field a has different types in pkg/a and pkg/A"),
        ("float32 a", {"a": "int32"}, "has different types"),
        ("uint8[] a", {"a": "uint8[3]"}, "has different types"),
        ("uint8[] a", {"a": "uint8"}, "has different types"),
        ("string a", {"a": "wstring"}, "has different types"),
        ("", {"a": "uint8"}, "only pkg/A of ROS 2 has field a"),
        ("uint8 a\nuint8 b", {"a": "uint8"}, "only pkg/a of ROS 1 has field b"),
        (
            "Inner a",
            {"a": "std_msgs/Header"},
            "pkg/Inner has field x in ROS 1 but std_msgs/Header",
        ),
    ],
)
def test_the_first_difference_is_named(text: str, other: Dict[str, str], sentence: str) -> None:
    assert sentence in str(difference_of(text, other))


def test_definition_of_ros2_is_the_same_in_terms_of_ros1() -> None:
    kinds = {
        **{"k": "double[9]", "flags": "sequence<boolean, 4>", "note": "string<20>"},
        **{"at": "builtin_interfaces/Time", "header": "std_msgs/Header"},
        **{"two": "pkg/Inner[2]", "all": "sequence<pkg/Inner>"},
    }
    found = in_ros1_terms("pkg/A", lambda name: {"pkg/A": kinds, **ROS2}[name])
    text = (
        "float64[9] k\nbool[] flags\nstring note\ntime at\nHeader header\nInner[2] two\nInner[] all"
    )
    assert found == parse("pkg/A", text + HEADER + SEPARATOR + "MSG: pkg/Inner\nfloat64 x\n")
    with pytest.raises(ValueError, match="pkg/A: w: ROS 1 has no type wstring"):
        in_ros1_terms("pkg/A", lambda _: {"w": "wstring"})
