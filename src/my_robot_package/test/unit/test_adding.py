"""Sums of int64."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from my_robot_package.nodes.add_two_ints_server import INT64_MAX, INT64_MIN, add

INT64 = st.integers(INT64_MIN, INT64_MAX)


@given(INT64, INT64)
def test_a_sum_is_right_or_refused(a: int, b: int) -> None:
    try:
        struct.pack("<q", a + b)
    except struct.error:
        with pytest.raises(OverflowError, match=rf"^{a} \+ {b} is {a + b}: must be in \["):
            add(a, b)
    else:
        assert add(a, b) == a + b


@pytest.mark.parametrize(
    "a, b, total",
    [(INT64_MAX, 0, INT64_MAX), (INT64_MIN, 0, INT64_MIN), (INT64_MAX, INT64_MIN, -1)],
)
def test_the_bounds_themselves_are_sums(a: int, b: int, total: int) -> None:
    assert add(a, b) == total


@pytest.mark.parametrize("a, b", [(INT64_MAX, 1), (INT64_MIN, -1)])
def test_sum_beyond_int64_is_rejected(a: int, b: int) -> None:
    with pytest.raises(OverflowError):
        add(a, b)
