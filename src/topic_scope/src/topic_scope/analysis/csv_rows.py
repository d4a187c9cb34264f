"""Samples as rows of a CSV file: one for each message, with all fields that were read of it."""

import math
from itertools import groupby
from typing import Any, Callable, Iterable, Iterator, List, NamedTuple, Sequence, Tuple

import numpy

_NAN = repr(math.nan)


class CsvColumn(NamedTuple):
    """The samples of one field.

    :param topic: topic of the field: the samples of one message share times and row
    :param times: when each was taken, ascending
    :param received: when each was received, or what else tells two of one time apart
    :param cells: what is written of each
    """

    topic: str
    times: numpy.ndarray
    received: numpy.ndarray
    cells: Sequence[str]


def header(*names: str) -> str:
    """Return the first row.

    :param names: names of the columns, those of the times before those of the fields
    """
    return ",".join(_cell(name) for name in names) + "\n"


def _cell(text: str) -> str:
    return quoted(text) if "," in text or '"' in text else text


def quoted(text: str) -> str:
    """Return a cell that holds any text, line ends included."""
    return '"' + text.replace('"', '""') + '"'


def rows(columns: Sequence[CsvColumn], stamp: Callable[[Any, Any], str]) -> Iterator[str]:
    """Return the rows, in the order of time.

    :param columns: the fields; a cell stays empty where a row is of another topic
    :param stamp: returns what a row begins with, of the time and the receipt of its message
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
    for (time, came, _), group in groupby(in_order, key=lambda one: one[0]):
        first = stamp(time, came)
        for row in _rows_of_one_time((cell for _, cell in group), len(columns)):
            yield ",".join([first] + row) + "\n"


def _rows_of_one_time(cells: Iterable[Tuple[int, str]], width: int) -> List[List[str]]:
    """Return a row for each message of a topic that nothing tells apart from the others.

    :param cells: which column each is of, and its text; those of a column in their order
    :param width: number of columns
    """
    made: List[List[str]] = []
    filled = [0] * width
    for index, cell in cells:
        if cell == _NAN and filled[index]:
            continue  # a line that ends has it at its last sample's time
        if filled[index] == len(made):
            made.append([""] * width)
        made[filled[index]][index] = cell
        filled[index] += 1
    return made
