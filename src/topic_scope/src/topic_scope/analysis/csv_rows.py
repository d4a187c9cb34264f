"""Samples as CSV rows: one row per message, with all of its recorded fields."""

import math
from itertools import groupby
from typing import Any, Callable, Iterable, Iterator, List, NamedTuple, Sequence, Tuple

import numpy

_NAN = repr(math.nan)


class CsvColumn(NamedTuple):
    """Samples of one field.

    :param topic: topic of the field: the samples of one message share times and row
    :param times: when each was taken, ascending
    :param received: receipt times, or other values that distinguish samples of the same time
    :param cells: text of each sample
    """

    topic: str
    times: numpy.ndarray
    received: numpy.ndarray
    cells: Sequence[str]


def header(*names: str) -> str:
    """Return the header row.

    :param names: column names, times before fields
    """
    return ",".join(_cell(name) for name in names) + "\n"


def _cell(text: str) -> str:
    return quoted(text) if "," in text or '"' in text else text


def quoted(text: str) -> str:
    """Return any text as a quoted cell, line ends included."""
    return '"' + text.replace('"', '""') + '"'


def rows(columns: Sequence[CsvColumn], stamp: Callable[[Any, Any], str]) -> Iterator[str]:
    """Return the rows in time order.

    :param columns: the fields; their cells are empty in rows of other topics
    :param stamp: returns the first cells of a row from the message's time and receipt time
    """
    filled = [(index, column) for index, column in enumerate(columns) if len(column.times)]
    if not filled:
        return
    topics = sorted({column.topic for _, column in filled})
    counts = [len(column.times) for _, column in filled]
    topic_of = numpy.repeat([topics.index(column.topic) for _, column in filled], counts)
    times = numpy.concatenate([column.times for _, column in filled])
    received = numpy.concatenate([column.received for _, column in filled])
    order = numpy.lexsort((topic_of, received, times))
    written = [(index, cell) for index, column in filled for cell in column.cells]
    stamps = zip(*(part[order].tolist() for part in (times, received, topic_of)))
    in_order = zip(stamps, map(written.__getitem__, order.tolist()))
    for (time, receipt, _), group in groupby(in_order, key=lambda one: one[0]):
        first = stamp(time, receipt)
        for row in _rows_of_one_time((cell for _, cell in group), len(columns)):
            yield ",".join([first] + row) + "\n"


def _rows_of_one_time(cells: Iterable[Tuple[int, str]], width: int) -> List[List[str]]:
    """Return a row for each message, for messages of equal time and receipt time.

    :param cells: column and text of each cell, in message order within a column
    :param width: number of columns
    """
    made: List[List[str]] = []
    filled = [0] * width
    for index, cell in cells:
        if cell == _NAN and filled[index]:
            continue  # the end of a line is marked at the time of its last sample
        if filled[index] == len(made):
            made.append([""] * width)
        made[filled[index]][index] = cell
        filled[index] += 1
    return made
