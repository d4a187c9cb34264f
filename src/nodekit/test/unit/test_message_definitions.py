"""Tests of the parser of message definitions."""

import struct
from typing import Optional

import pytest
from genpy.base import SIMPLE_TYPES_DICT
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float64MultiArray, Header

from nodekit.message_definitions import (
    SIZES,
    Constant,
    DefinitionError,
    Field,
    constant_in,
    field_in,
    fields_of,
    parse,
    parts_of,
)

LINE = "=" * 80


@pytest.mark.parametrize(
    "line, field",
    [
        ("float32 x", Field("float32", False, None, "x")),
        ("  time[2]  when   # twice", Field("time", True, 2, "when")),
        ("string[] names", Field("string", True, None, "names")),
        ("int8[0] none", Field("int8", True, 0, "none")),
        ("Header header", Field("std_msgs/Header", False, None, "header")),
        ("roslib/Header h", Field("std_msgs/Header", False, None, "h")),
        ("Inner inner", Field("pkg/Inner", False, None, "inner")),
        ("geometry_msgs/Point[9] a_b2", Field("geometry_msgs/Point", True, 9, "a_b2")),
        ("", None),
        ("  # float32 x", None),
        ("uint8 X=3", None),
    ],
)
def test_field_of_a_line(line: str, field: Optional[Field]) -> None:
    assert field_in(line, "pkg") == field


@pytest.mark.parametrize("line", ["float32", "float32 a b", "float32[x] y", "2d x", "a-b x", "=3"])
def test_a_line_that_makes_no_sense_is_refused(line: str) -> None:
    with pytest.raises(DefinitionError, match="is not a field of a message"):
        field_in(line, "pkg")


@pytest.mark.parametrize(
    "line, constant",
    [
        ("uint8 SMALL = 3 # three", Constant("uint8", "SMALL", "3")),
        ("string TEXT= a = b # c ", Constant("string", "TEXT", "a = b # c")),
        ("float32 x", None),
        ("# int8 A=1", None),
    ],
)
def test_constant_of_a_line(line: str, constant: Optional[Constant]) -> None:
    assert constant_in(line) == constant


def test_numbers_are_as_long_as_genpy_writes_them() -> None:
    assert SIZES == {name: struct.calcsize(note) for name, note in SIMPLE_TYPES_DICT.items()}


def test_definitions_of_real_messages() -> None:
    found = parse("std_msgs/Float64MultiArray", Float64MultiArray._full_text)
    assert list(found) == [
        "std_msgs/Float64MultiArray",
        "std_msgs/MultiArrayLayout",
        "std_msgs/MultiArrayDimension",
    ]
    dimension = found["std_msgs/MultiArrayDimension"]
    assert [field.name for field in dimension] == ["label", "size", "stride"]
    log = parse("rosgraph_msgs/Log", Log._full_text)
    assert [field.name for field in log["rosgraph_msgs/Log"]] == list(Log.__slots__)
    assert log["std_msgs/Header"] == fields_of("std_msgs/Header", Header._full_text)


def test_parts_have_names() -> None:
    text = f"B b\n{LINE}\nMSG: a/B\nint8 x\n{LINE}  \n MSG: a/C \nint8 y"
    assert parts_of("a/A", text) == {"a/A": "B b\n", "a/B": "int8 x", "a/C": "int8 y"}
    with pytest.raises(DefinitionError, match="no name is given to a part .* of a/A"):
        parts_of("a/A", f"B b\n{LINE}\nint8 x")


@pytest.mark.parametrize(
    "text, words",
    [
        ("B b", "the type a/B is not defined"),
        ("a/A x", "the type a/A contains itself"),
        (f"B b\n{LINE}\nMSG: a/B\na/A y", "the type a/A contains itself"),
        (f"B b\n{LINE}\nMSG: a/B\nC y", "the type a/C is not defined"),
    ],
)
def test_types_that_cannot_be_are_refused(text: str, words: str) -> None:
    with pytest.raises(DefinitionError, match=words):
        parse("a/A", text)


def test_type_used_along_many_paths_is_checked_once() -> None:
    """Each type has two fields of the next one: 2**40 paths lead to the last."""
    parts = ["T0 a\nT0 b\n", *(f"MSG: a/T{n}\nT{n + 1} a\nT{n + 1} b\n" for n in range(40))]
    found = parse("a/A", f"{LINE}\n".join([*parts, "MSG: a/T40\nint8 x"]))
    assert len(found) == 42
