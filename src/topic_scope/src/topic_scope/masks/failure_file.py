"""CSV file with the samples around the first mask failure."""

import math
import os
from typing import Iterator

from topic_scope.analysis.csv_rows import CsvColumn, header, rows
from topic_scope.masks.limits import Mask, SampleReader
from topic_scope.timing.nanoseconds import exact_seconds, to_ns

#: How much of what came before is saved [s].
BEFORE_S = 2.0


def save_failure(path: str, samplers: SampleReader, mask: Mask, moment: float) -> None:
    """Write the trace, its reference and both limits to a CSV file, from before a time on.

    :param path: the file; it appears when it is complete
    :param samplers: knows the samples
    :param moment: when the trace was outside for the first time [s]
    :raises OSError: if it cannot be written
    """
    partial = path + ".part"
    with open(partial, "w", newline="") as file:
        file.writelines(_lines(samplers, mask, moment - BEFORE_S))
    os.replace(partial, path)


def _lines(samplers: SampleReader, mask: Mask, start: float) -> Iterator[str]:
    names = (mask.field, mask.reference, mask.lower, mask.upper)
    traces = {name: samplers.trace(name) for name in names}
    columns = []
    for trace in traces.values():
        assert trace is not None  # else nothing would have been checked
        times, values, received = trace.rows(to_ns(start), to_ns(math.inf))
        cells = [repr(value) for value in values.tolist()]
        columns.append(CsvColumn(trace.stream.topic, times, received, cells))
    yield header("time", "received", *traces)
    yield from rows(columns, lambda time, came: f"{exact_seconds(time)},{exact_seconds(came)}")
