"""Write numbers from a bag to a CSV file, exactly as they were recorded."""

import csv
from typing import Any, Iterable, List, TextIO

import numpy

from topic_scope.bag.bag_columns import Column
from topic_scope.bag.bag_reading import Sample
from topic_scope.messages.definitions import layout_of
from topic_scope.messages.derived import make, parts
from topic_scope.messages.timestamp_source import path_of
from topic_scope.messages.values import getter, value_at


def write_csv(file: TextIO, columns: List[Column], samples: Iterable[Sample]) -> int:
    """Write a row for each message: its time, s, and the numbers in it.

    What is of another topic, or of an array that is too short for it, stays empty.

    :param file: opened with ``newline=""``
    :param columns: what to write
    :param samples: the messages
    :returns: how many messages there were
    """
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["time"] + [column.name for column in columns])
    computed = {column: _Computed(column) for column in columns if column.function}
    count = 0
    for sample in samples:
        count += 1
        cells = [computed.get(column, _cell)(column, sample) for column in columns]
        writer.writerow([exact_seconds(sample.time)] + cells)
    return count


def exact_seconds(nanoseconds: int) -> str:
    """Return a time in s, without rounding it."""
    seconds, rest = divmod(abs(nanoseconds), 10**9)
    return f"{'-' if nanoseconds < 0 else ''}{seconds}.{rest:09}"


class _Computed:
    """Writes what is computed of a number, as its messages come.

    :param column: what to write
    """

    def __init__(self, column: Column) -> None:
        self._function = make(column.function)
        self._getters = [getter(column.path + part) for part in parts(column.function)]

    def __call__(self, column: Column, sample: Sample) -> str:
        if column.topic != sample.topic:
            return ""
        time = path_of(column.timestamp, layout_of(type(sample.message)))
        moment = getter(time)(sample.message) if time else sample.time / 1e9
        row = numpy.array([[get(sample.message)] for get in self._getters])
        values = self._function(numpy.array([moment]), row).tolist()
        return repr(values[0]) if values else ""


def _cell(column: Column, sample: Sample) -> str:
    if column.topic != sample.topic:
        return ""
    value: Any = value_at(sample.message, column.path)
    if value is None:
        return ""
    if hasattr(value, "to_nsec"):
        return exact_seconds(value.to_nsec())
    return repr(int(value) if isinstance(value, bool) else value)
