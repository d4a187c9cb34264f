"""CSV file with the samples around the first mask failure."""

import math
import os
from typing import Iterator

from topic_scope.analysis.csv_rows import CsvColumn, header, rows
from topic_scope.masks.mask_check import Mask, SampleReader
from topic_scope.timing.nanoseconds import exact_seconds, to_ns

#: Time to save before the failure [s].
BEFORE_S = 2.0


def save_failure(path: str, samplers: SampleReader, mask: Mask, moment: float) -> None:
    """Write the trace, its reference and both limits to a CSV file, from shortly before a time on.

    :param path: the file, written atomically
    :param samplers: reader of the samples
    :param moment: time of the first sample outside [s]
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
        assert trace is not None  # otherwise no sample would have been checked
        times, values, received = trace.rows(to_ns(start), to_ns(math.inf))
        cells = [repr(value) for value in values.tolist()]
        columns.append(CsvColumn(trace.stream.topic, times, received, cells))
    yield header("time", "received", *traces)
    yield from rows(
        columns, lambda time, receipt: f"{exact_seconds(time)},{exact_seconds(receipt)}"
    )
