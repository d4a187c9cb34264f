"""Parameters as ROS 2 has them."""

import math
from typing import Any, Optional

import numpy
import pytest

from nodekit import (
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterSet,
    StringParameter,
    describe,
)
from ros2_bridge.parameters import values


@pytest.mark.parametrize(
    "value, kind",
    [
        *[(True, 1), (3, 2), (0.5, 3), ("a", 4), ([True], 6), ([1, 2], 7), ([1, 2.5], 8)],
        *[([0.5], 8), (["a"], 9), ([], 0), ([1, "a"], 0), ({}, 0), (None, 0), ([[1]], 0)],
    ],
)
def test_type_of_plain_value(value: Any, kind: int) -> None:
    assert values.kind_of(value) == kind


class Sample(ParameterSet):
    any_number = FloatParameter(0.0, help="anything", unit="m")
    closed = FloatParameter(0.0, minimum=-1.0, maximum=2.0, step=0.5, help="closed")
    opened = FloatParameter(0.5, above=0.0, below=1.0, help="open")
    count = IntParameter(3, above=2.5, maximum=7, help="count")
    inside = IntParameter(3, above=0, below=9, help="inside")
    late = IntParameter(3, below=9.5, help="late")
    gains = ListParameter((1.0,), element=FloatParameter(0.0, help="gain"), help="gains")
    color = EnumParameter("red", choices=("red", "blue"), help="color")
    names = ListParameter((), element=StringParameter("", help="name"), help="names")


ENTRIES = {entry["name"]: entry for entry in describe(Sample())}


@pytest.mark.parametrize(
    "name, limits, kind",
    [
        ("any_number", None, values.DOUBLE),
        ("closed", (-1.0, 2.0, 0.5), values.DOUBLE),
        ("opened", (numpy.nextafter(0.0, 1.0), numpy.nextafter(1.0, 0.0), 0.0), values.DOUBLE),
        ("count", (3, 7, 1), values.INTEGER),
        ("inside", (1, 8, 1), values.INTEGER),
        ("late", (-(2**31), 9, 1), values.INTEGER),
        ("gains", None, values.DOUBLES),
        ("color", None, values.STRING),
        ("names", None, values.STRINGS),
    ],
)
def test_declared_parameters(name: str, limits: Optional[Any], kind: int) -> None:
    assert values.range_of(ENTRIES[name]) == limits
    assert values.declared_kind(ENTRIES[name]) == kind


def test_one_sided_range_ends_at_the_largest_numbers() -> None:
    entry = {"type": "int", "minimum": 5}
    assert values.range_of(entry) == (5, 2**31 - 1, 1)
    assert values.range_of({"type": "float", "maximum": 5.0}) == (-1.7976931348623157e308, 5.0, 0.0)


def test_words() -> None:
    assert values.description_of(ENTRIES["any_number"]) == ("anything (m)", "")
    assert values.description_of(ENTRIES["color"]) == ("color", "one of red, blue")
    assert values.description_of({**ENTRIES["closed"], "exact": False})[1] == (
        "[-1, 2]; and further checks when it is set"
    )


def test_names_have_dots() -> None:
    tree = {"gain": 2, "pid": {"p": 0.5, "limits": {"low": 1}}}
    assert values.flat(tree) == {"gain": 2, "pid.p": 0.5, "pid.limits.low": 1}
    assert values.ros1_key("pid.limits.low") == "pid/limits/low"


@pytest.mark.parametrize(
    "value, kind, fitting",
    [
        *[(1, values.INTEGER, values.INTEGER), ("a", values.INTEGER, values.STRING)],
        *[([], values.INTEGERS, values.INTEGERS), ([], values.STRING, values.NOT_SET)],
        *[([1], values.BYTES, values.BYTES), ([], values.BYTES, values.BYTES)],
        *[(["a"], values.BYTES, values.STRINGS), ([1], values.INTEGERS, values.INTEGERS)],
    ],
)
def test_type_of_value_from_ros1(value: Any, kind: int, fitting: int) -> None:
    assert values.fitting_kind(value, kind) == fitting


def test_bytes_are_whole_numbers_in_ros1() -> None:
    assert values.as_kind([1, 255], values.BYTES) == [b"\1", b"\xff"]
    with pytest.raises(ValueError):
        values.as_kind([256], values.BYTES)


def test_changes() -> None:
    old = {"same": 1, "kind": 1, "value": 1, "gone": 1}
    new = {"same": 1, "kind": 1.0, "value": 2, "new": 1}
    assert values.changes(old, new) == ({"new": 1}, {"kind": 1.0, "value": 2}, {"gone": 1})


@pytest.mark.parametrize(
    "one, other, is_same",
    [
        *[(math.nan, float("nan"), True), ([1.5, math.nan], [1.5, float("nan")], True)],
        *[(math.nan, 1.0, False), (1, 1.0, False), (1, True, False), ([1], [1.0], False)],
        *[(0.1, 0.1, True), ("a", "a", True), (None, None, True), ("1", 1, False)],
    ],
)
def test_values_that_are_the_same(one: Any, other: Any, is_same: bool) -> None:
    assert values.is_same(one, other) is is_same
    assert values.changes({"x": one}, {"x": other}) == ({}, {} if is_same else {"x": other}, {})


@pytest.mark.parametrize(
    "prefixes, depth, names",
    [
        ([], 0, ["a", "b.c", "b.d.e"]),
        ([], 1, ["a"]),
        ([], 2, ["a", "b.c"]),
        (["b"], 0, ["b.c", "b.d.e"]),
        (["b"], 1, ["b.c"]),
        (["a"], 1, ["a"]),
        (["x"], 0, []),
    ],
)
def test_list(prefixes: Any, depth: int, names: Any) -> None:
    found, spaces = values.listed(["a", "b.c", "b.d.e"], prefixes, depth)
    assert found == names
    assert spaces == sorted({name.rpartition(".")[0] for name in names if "." in name})


def test_pending_values() -> None:
    assert values.differs({"a": 1, "b": 2}, {"a": 1, "b": 3})
    assert not values.differs({"a": 1, "b": 2}, {"a": 1.0, "c": 3})
    assert not values.differs({"a": math.nan}, {"a": float("nan")})


@pytest.mark.parametrize(
    "value, words",
    [
        (None, "x cannot be removed"),
        (2**31, "refused 2147483648: ROS 1 carries integers of 32 bits only"),
        ([1, -(2**31) - 1], "refused -2147483649"),
        ("a\0b", "no control characters"),
        (["a", "\x1f"], "no control characters"),
        ("a\r\nb", "no control characters"),
    ],
)
def test_values_unsupported_by_ros1(value: Any, words: str) -> None:
    assert words in values.unfit("x", value)


@pytest.mark.parametrize("value", [2**31 - 1, -(2**31), 1e300, "a\tb\n", True, [], [1, 2], [""]])
def test_values_supported_by_ros1(value: Any) -> None:
    assert values.unfit("x", value) == ""
