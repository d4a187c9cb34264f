"""Series of a bag's lines, by the names of the lines."""

import struct
from typing import Iterable, List, Mapping, Sequence, Tuple

from topic_scope.bag.columns import Line, choose_lines
from topic_scope.bag.file import BagFile
from topic_scope.bag.message_slices import FirstMessage, Slice
from topic_scope.bag.series import Series, collect, computed
from topic_scope.bag.column_reader import ColumnReader


def chosen(
    bag: BagFile, first: Mapping[str, FirstMessage], names: Sequence[str]
) -> Tuple[List[Line], List[ColumnReader]]:
    """Return what names stand for in a bag, and what reads that.

    :param bag: the bag
    :param first: as :func:`.first_messages` returns them
    :param names: of fields, or of what is computed
    :raises FieldError: if there is no such field, or a formula is wrong
    """
    lines = choose_lines(list(names), first)
    columns = dict.fromkeys(column for line in lines for column in line.columns)
    return lines, [ColumnReader(column, first[column.topic], bag.start) for column in columns]


def series_of(
    bag: BagFile,
    lines: Sequence[Line],
    readers: List[ColumnReader],
    messages: Iterable[List[Slice]],
) -> List[Series]:
    """Return lines over time.

    :param bag: the bag
    :param lines: as :func:`chosen` returns them
    :param readers: the same
    :param messages: of their topics
    :raises BagError: if a part of the bag is broken
    """
    try:
        found = collect(readers, messages)
    except struct.error as error:
        raise bag.broken(error) from error
    series = {one.name: one for one in found}
    return [
        computed(line.name, line.formula, found) if line.formula else series[line.name]
        for line in lines
    ]
