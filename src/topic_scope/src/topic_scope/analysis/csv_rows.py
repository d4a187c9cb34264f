"""Samples as rows of a CSV file: one for each message, with all fields that were read of it."""

from itertools import groupby
from typing import Iterator, List, NamedTuple, Sequence

import numpy

from topic_scope.analysis.ring import Samples

_NOTHING = numpy.empty(0)


class Column(NamedTuple):
    """The samples of one field.

    :param topic: topic of the field: the samples of one message share times and row
    :param samples: times and values
    :param received: when each was received, s
    """

    topic: str
    samples: Samples
    received: numpy.ndarray


def header(fields: Sequence[str]) -> str:
    """Return the first row.

    :param fields: their names
    """
    return ",".join(["time", "received"] + list(fields)) + "\n"


def rows(columns: Sequence[Column]) -> Iterator[str]:
    """Return the rows, in the order of time; each number with all of its digits.

    :param columns: the fields; a cell stays empty where a row is of another topic
    """
    topics = sorted({column.topic for column in columns})
    counts = [len(column.samples[0]) for column in columns]
    column_of = numpy.repeat(numpy.arange(len(columns)), counts)
    topic_of = numpy.repeat([topics.index(column.topic) for column in columns], counts)
    times = numpy.concatenate([_NOTHING] + [column.samples[0] for column in columns])
    values = numpy.concatenate([_NOTHING] + [column.samples[1] for column in columns])
    received = numpy.concatenate([_NOTHING] + [column.received for column in columns])
    order = numpy.lexsort((topic_of, received, times))
    parts = (column_of, topic_of, times, received, values)
    cells = zip(*(part[order].tolist() for part in parts))
    for (_, time, came), group in groupby(cells, key=lambda cell: cell[1:4]):
        row: List[str] = [""] * len(columns)
        for column_index, *_, value in group:
            row[column_index] = repr(value)
        yield ",".join([repr(time), repr(came)] + row) + "\n"
