"""CSV files contain every sample exactly, in one row per message."""

import csv
import io
from typing import List

import numpy
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.csv_rows import CsvColumn, header, rows


def both(time: object, received: object) -> str:
    """Write both times."""
    return f"{time!r},{received!r}"


TIMES = st.lists(st.floats(0.0, 2e9), max_size=30, unique=True).map(sorted)


@settings(max_examples=30)
@given(TIMES, TIMES, st.randoms(use_true_random=False))
def test_the_numbers_come_back_exactly(
    one: List[float], other: List[float], random: object
) -> None:
    numbers = [random.uniform(-1, 1) for _ in range(2 * len(one) + len(other))]  # type: ignore
    x, y, z = numbers[: len(one)], numbers[len(one) : 2 * len(one)], numbers[2 * len(one) :]
    columns = [
        CsvColumn("/a", numpy.array(one), numpy.array(one) + 0.25, list(map(repr, x))),
        CsvColumn("/b", numpy.array(other), numpy.array(other), list(map(repr, z))),
        CsvColumn("/a", numpy.array(one), numpy.array(one) + 0.25, list(map(repr, y))),
    ]
    fields = ["/a/x", "/b/z", "/a/y"]
    first = header("time", "received", *fields)
    read = list(csv.DictReader(io.StringIO(first + "".join(rows(columns, both)))))
    assert len(read) == len(one) + len(other)
    assert [float(row["time"]) for row in read] == sorted(one + other)
    received_at = [float(row["received"]) for row in read if row["/a/x"]]
    assert received_at == (numpy.array(one) + 0.25).tolist()
    for field, times, values in (("/a/x", one, x), ("/b/z", other, z), ("/a/y", one, y)):
        filled = [(float(row["time"]), float(row[field])) for row in read if row[field]]
        assert filled == list(zip(times, values))
    assert all(bool(row["/a/x"]) == bool(row["/a/y"]) != bool(row["/b/z"]) for row in read)


def test_messages_of_one_time_keep_their_rows_and_whole_numbers_their_digits() -> None:
    times = numpy.array([2**62 + 1, 2**62 + 1])
    column = CsvColumn("/a", times, numpy.array([0, 1]), ["3", ""])
    other = CsvColumn("/b", times[:0], times[:0], [])
    assert list(rows([column, other], both)) == [f"{2**62 + 1},0,3,\n", f"{2**62 + 1},1,,\n"]
    assert list(rows([other], both)) == []


def test_messages_of_one_time_are_in_the_order_of_receipt() -> None:
    columns = [
        CsvColumn(topic, numpy.array([0.0]), numpy.array([received]), [topic])
        for topic, received in (("/a", 2.0), ("/b", 1.0))
    ]
    assert list(rows(columns, both)) == ["0.0,1.0,,/b\n", "0.0,2.0,/a,\n"]


def test_indistinguishable_messages_have_a_row_each() -> None:
    """Messages of an overlaid bag have no receipt time of their own."""
    times = numpy.array([5.0, 5.0, 5.0, 6.0])
    columns = [
        CsvColumn("/a", times, times, ["1", "2", "3", "4"]),
        CsvColumn("/a", times[2:], times[2:], ["8", "9"]),
    ]
    expected = ["5.0,5.0,1,8\n", "5.0,5.0,2,\n", "5.0,5.0,3,\n", "6.0,6.0,4,9\n"]
    assert list(rows(columns, both)) == expected


def test_where_a_line_ends_its_last_sample_stays() -> None:
    times = numpy.array([1.0, 2.0, 2.0, 9.0, 10.0])
    cells = ["0.5", "1.5", "nan", "2.5", "nan"]
    assert list(rows([CsvColumn("/a", times, times, cells)], both)) == [
        "1.0,1.0,0.5\n",
        "2.0,2.0,1.5\n",
        "9.0,9.0,2.5\n",
        "10.0,10.0,nan\n",
    ]


def test_a_name_with_a_comma_is_one_cell() -> None:
    names = ["time", "=atan2(/a, /b)", '"/a-b"/c']
    assert next(csv.reader([header(*names)])) == names
