"""Comparison of definitions of ROS 2 types, as nodes describe them."""

from typing import Dict, List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.types.type_descriptions import (
    Field,
    as_text,
    flatten,
    has_same_layout,
    is_renamed_in_order,
    kind_of,
)

GAINS = [Field("kp", "double"), Field("ki", "double")]
TYPES: Dict[str, List[Field]] = {
    "a/msg/Gains": GAINS,
    "a/msg/Loop": [
        Field("rate", "float"),
        Field("gains", "a/msg/Gains"),
        Field("earlier", "a/msg/Gains[]"),
    ],
    "a/msg/Robot": [Field("loop", "a/msg/Loop")],
}


def test_nested_fields_are_in_serialization_order() -> None:
    assert as_text(flatten(TYPES, "a/msg/Loop")) == (
        "float rate, double gains.kp, double gains.ki, [] earlier, double earlier.kp, "
        "double earlier.ki"
    )
    assert as_text(flatten(TYPES, "a/msg/Robot")[:2]) == "float loop.rate, double loop.gains.kp"


@pytest.mark.parametrize(
    "name, nested, capacity, kind",
    [
        ("double", "", 0, "double"),
        ("double_array", "", 3, "double[3]"),
        ("double_unbounded_sequence", "", 0, "double[]"),
        ("double_bounded_sequence", "", 3, "double[<=3]"),
        ("nested_type", "a/msg/Gains", 0, "a/msg/Gains"),
        ("nested_type_array", "a/msg/Gains", 2, "a/msg/Gains[2]"),
    ],
)
def test_kinds_are_named_with_their_lengths(
    name: str, nested: str, capacity: int, kind: str
) -> None:
    assert kind_of(name, nested, capacity) == kind


def test_swapped_fields_are_not_treated_as_renamed() -> None:
    swapped = GAINS[::-1]
    assert has_same_layout(GAINS, swapped) and not is_renamed_in_order(GAINS, swapped)


def test_renamed_fields_differ_from_other_layout() -> None:
    renamed = [Field("gain", "double"), Field("ki", "double")]
    assert is_renamed_in_order(GAINS, renamed)
    assert not is_renamed_in_order(GAINS, [*renamed, Field("kd", "double")])
    assert not is_renamed_in_order(GAINS, [Field("kp", "float"), Field("ki", "double")])


fields = st.lists(
    st.builds(Field, st.sampled_from("abcd"), st.sampled_from(["double", "float"])),
    unique_by=lambda field: field.name,
)


@given(fields, fields)
def test_renamed_in_order_never_swaps_values(ours: List[Field], theirs: List[Field]) -> None:
    if is_renamed_in_order(ours, theirs):
        for name in {field.name for field in ours} & {field.name for field in theirs}:
            assert [f.name for f in ours].index(name) == [f.name for f in theirs].index(name)
    assert is_renamed_in_order(ours, ours)


def test_long_definitions_are_cut() -> None:
    many = [Field(f"f{number}", "double") for number in range(20)]
    assert as_text(many).endswith("double f11, and 8 more")
    assert as_text(many[:12]).endswith("double f11")
