"""CSV holds every sample exactly, in one row for each message."""

import csv
import io
from typing import List

import numpy
from hypothesis import given
from hypothesis import strategies as st

from topic_scope.analysis.csv_rows import Column, header, rows

TIMES = st.lists(st.floats(0.0, 2e9), max_size=30, unique=True).map(sorted)


@given(TIMES, TIMES, st.randoms(use_true_random=False))
def test_the_numbers_come_back_exactly(
    one: List[float], other: List[float], random: object
) -> None:
    numbers = [random.uniform(-1, 1) for _ in range(2 * len(one) + len(other))]  # type: ignore
    x, y, z = numbers[: len(one)], numbers[len(one) : 2 * len(one)], numbers[2 * len(one) :]
    columns = [
        Column("/a", (numpy.array(one), numpy.array(x)), numpy.array(one) + 0.25),
        Column("/b", (numpy.array(other), numpy.array(z)), numpy.array(other)),
        Column("/a", (numpy.array(one), numpy.array(y)), numpy.array(one) + 0.25),
    ]
    fields = ["/a/x", "/b/z", "/a/y"]
    read = list(csv.DictReader(io.StringIO(header(fields) + "".join(rows(columns)))))
    assert len(read) == len(one) + len(other)
    assert [float(row["time"]) for row in read] == sorted(one + other)
    came = [float(row["received"]) for row in read if row["/a/x"]]
    assert came == (numpy.array(one) + 0.25).tolist()
    for field, times, values in (("/a/x", one, x), ("/b/z", other, z), ("/a/y", one, y)):
        filled = [(float(row["time"]), float(row[field])) for row in read if row[field]]
        assert filled == list(zip(times, values))
    assert all(bool(row["/a/x"]) == bool(row["/a/y"]) != bool(row["/b/z"]) for row in read)


def test_what_is_no_number_stays_visible() -> None:
    times = numpy.array([1.0, 2.0])
    column = Column("/a", (times, numpy.array([numpy.nan, numpy.inf])), times + 0.5)
    assert list(rows([column])) == ["1.0,1.5,nan\n", "2.0,2.5,inf\n"]


def test_messages_of_one_stamp_keep_their_rows() -> None:
    samples = (numpy.array([1.0, 1.0]), numpy.array([3.0, 4.0]))
    column = Column("/a", samples, numpy.array([1.5, 2.5]))
    assert list(rows([column])) == ["1.0,1.5,3.0\n", "1.0,2.5,4.0\n"]
