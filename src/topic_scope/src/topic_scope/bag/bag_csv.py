"""Write numbers from a bag to a CSV file, exactly as they were recorded."""

from typing import Iterable, List, TextIO

from topic_scope.analysis.csv_rows import header, rows
from topic_scope.bag.bag_messages import Slice
from topic_scope.bag.column_reader import ColumnReader, exact_seconds


def write_csv(file: TextIO, readers: List[ColumnReader], slices: Iterable[List[Slice]]) -> None:
    """Write a row for each message: its time, s, and the numbers in it.

    What is of another topic, or of an array that is too short for it, stays empty.

    :param file: where to write
    :param readers: read what is written, column by column
    :param slices: the messages
    :raises struct.error: if a message is cut off
    """
    file.write(header("time", *(reader.column.name for reader in readers)))
    for found in slices:
        of_topic = {one.topic: one for one in found}
        columns = [
            reader.cells(of_topic.get(reader.column.topic, Slice.empty(reader.column.topic)))
            for reader in readers
        ]
        file.writelines(rows(columns, lambda time, _index: exact_seconds(time)))
