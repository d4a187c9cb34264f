"""CSV files contain exactly the recorded values."""

import csv
import io
import math
from decimal import Decimal
from typing import List, Tuple

import genpy
import pytest
from bags import BagMessage, reading, slices
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Bool, Duration, Float32, Float64, Float64MultiArray, Int64, Time

from topic_scope.bag.columns import Column
from topic_scope.bag.column_reader import write_csv
from topic_scope.messages.fields import FieldError
from topic_scope.timing.nanoseconds import exact_seconds


def rows(columns: List[Column], sent: List[BagMessage]) -> List[List[str]]:
    """Return the written cells."""
    file = io.StringIO(newline="")
    write_csv(file, reading(columns, sent), slices(sent))
    return list(csv.reader(io.StringIO(file.getvalue(), newline="")))


def same(one: float, other: float) -> bool:
    return one == other or math.isnan(one) and math.isnan(other)


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(0, 10**15), st.floats()), min_size=1).map(sorted))
def test_every_float_and_every_time_can_be_read_back_exactly(
    recorded: List[Tuple[int, float]],
) -> None:
    samples = [(time, "/x", Float64(value)) for time, value in recorded]
    header, *written = rows([Column("/x", ("data",))], samples)
    assert header == ["time", "/x/data"]
    assert [(int(time.replace(".", ""))) for time, _ in written] == [time for time, _ in recorded]
    assert all(same(float(w), value) for (_, w), (_, value) in zip(written, recorded))


@settings(max_examples=30)
@given(st.integers(-(2**63), 2**63 - 1))
def test_whole_numbers_are_not_rounded(value: int) -> None:
    assert rows([Column("/x", ("data",))], [(0, "/x", Int64(value))])[1][1] == str(value)


@settings(max_examples=30)
@given(st.integers(-(10**18), 10**18))
def test_seconds_are_not_rounded(nanoseconds: int) -> None:
    assert Decimal(exact_seconds(nanoseconds)) == Decimal(nanoseconds).scaleb(-9)


def test_non_finite_values() -> None:
    columns = [Column(topic, ("data",)) for topic in ("/bool", "/time", "/duration")]
    samples = [
        (0, "/bool", Bool(True)),
        (10**8, "/time", Time(genpy.Time(1700000000, 123456789))),
        (2 * 10**8, "/duration", Duration(genpy.Duration(-1, 500000000))),
    ]
    assert rows(columns, samples)[1:] == [
        ["0.000000000", "1", "", ""],
        ["0.100000000", "", "1700000000.123456789", ""],
        ["0.200000000", "", "", "-0.500000000"],
    ]


def test_difference_starts_with_the_second_message() -> None:
    columns = [Column("/x", ("data",), "", "derivative"), Column("/x", ("data",))]
    samples = [(time * 10**9, "/x", Float64(value)) for time, value in ((0, 1.0), (2, 5.0))]
    assert rows(columns, samples) == [
        ["time", "/x/data.derivative", "/x/data"],
        ["0.000000000", "", "1.0"],
        ["1.000000000", "2.0", ""],
        ["2.000000000", "", "5.0"],
    ]


def test_fields_of_one_message_share_its_row() -> None:
    columns = [Column("/x", ("data", 0)), Column("/y", ("data",)), Column("/x", ("data", 1))]
    samples = [
        (0, "/x", Float64MultiArray(data=[1.5, 2.5])),
        (0, "/y", Float32(3.5)),
        (1, "/x", Float64MultiArray(data=[4.5])),
    ]
    assert rows(columns, samples) == [
        ["time", "/x/data[0]", "/y/data", "/x/data[1]"],
        ["0.000000000", "1.5", "", "2.5"],
        ["0.000000000", "", "3.5", ""],
        ["0.000000001", "4.5", "", ""],
    ]


def test_longest_array_is_named_if_an_element_is_in_no_message() -> None:
    samples = [(n, "/x", Float64MultiArray(data=[1.0] * size)) for n, size in enumerate((1, 3, 2))]
    readers = reading([Column("/x", ("data", 5))], samples)
    write_csv(io.StringIO(), readers, slices(samples))
    with pytest.raises(FieldError, match="data has 3 elements at most"):
        readers[0].check()
