"""CSV writer for a bag's fields together with values computed from them by formulas."""

from typing import Iterable, List, Sequence, TextIO

import numpy

from topic_scope.analysis.csv_rows import CsvColumn, header, rows
from topic_scope.bag.columns import Line
from topic_scope.bag.message_slices import Slice
from topic_scope.bag.column_reader import ColumnReader
from topic_scope.formulas.signals import Signal
from topic_scope.messages.timestamp_source import longest_step
from topic_scope.timing.nanoseconds import exact_seconds


def write_computed_csv(
    file: TextIO, lines: Sequence[Line], readers: List[ColumnReader], slices: Iterable[List[Slice]]
) -> None:
    """Write a row for each message, and for each sample of a formula at another time.

    A value is in the row of the message that determines its time. All data are in memory
    together, because a formula may look far back and ahead.

    :param file: the output
    :param lines: the columns
    :param readers: readers of the fields that the lines are computed from
    :param slices: the messages
    """
    parts: List[List[CsvColumn]] = [[] for _ in readers]
    for found in slices:
        of_topic = {one.topic: one for one in found}
        for reader, gathered in zip(readers, parts):
            topic = reader.column.topic
            gathered.append(reader.cells(of_topic.get(topic, Slice.empty(topic))))
    columns = {
        reader.column.name: _joined(reader.column.topic, gathered)
        for reader, gathered in zip(readers, parts)
    }
    signals = {
        reader.column.name: _signal(columns[reader.column.name], reader)
        for reader in readers
        if reader.states is None
    }
    written = [
        _computed(columns[line.columns[0].name].topic, line.formula.computed(signals))
        if line.formula
        else columns[line.name]
        for line in lines
    ]
    file.write(header("time", *(line.name for line in lines)))
    file.writelines(rows(written, lambda time, _index: exact_seconds(time)))


def _joined(topic: str, parts: Sequence[CsvColumn]) -> CsvColumn:
    """Return a column joined in time order; indices identify the messages."""
    times = numpy.concatenate([numpy.empty(0, numpy.int64), *(part.times for part in parts)])
    cells = [cell for part in parts for cell in part.cells]
    order = times.argsort(kind="stable")
    return CsvColumn(topic, times[order], order, [cells[index] for index in order.tolist()])


def _signal(column: CsvColumn, reader: ColumnReader) -> Signal:
    """Return a column as numbers."""
    there = numpy.array([cell != "" for cell in column.cells], bool)
    times = column.times[there]
    values = numpy.array([float(cell) for cell in column.cells if cell])
    path = reader.stamp_path if reader.is_exact else None
    return Signal(times, values, column.received[there], longest_step(path, times))


def _computed(topic: str, signal: Signal) -> CsvColumn:
    cells = [repr(one) for one in signal.values.tolist()]
    return CsvColumn(topic, signal.times, signal.received, cells)
