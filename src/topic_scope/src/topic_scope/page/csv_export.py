"""Make a CSV file of what is recorded, bit by bit."""

from typing import AsyncIterator, Optional, Sequence

import numpy

from topic_scope.analysis.csv_rows import CsvColumn, header, rows
from topic_scope.sampling.computed_trace import Recorded
from topic_scope.sampling.recorder import Recorder

#: Length of a part [s]; frames are sent in between.
PART_S = 0.25

_NOTHING = numpy.empty(0)


async def parts(
    recorder: Recorder, names: Sequence[str], start: float, end: float
) -> AsyncIterator[str]:
    """Return the parts of a file.

    :param recorder: has the samples
    :param names: names of the fields
    :param start: start of the time span [s]
    :param end: end of the time span [s]
    """
    recorder.update()
    spans = [trace.span for trace in map(recorder.trace, names) if trace and trace.span]
    begin = max(start, min([first for first, _ in spans], default=end))
    end = min(end, max([last for _, last in spans], default=start))
    yield header("time", "received", *names)
    while begin <= end:
        stop = begin + PART_S
        last = min(end, float(numpy.nextafter(stop, begin)))
        traces = [recorder.trace(name) for name in names]
        yield "".join(rows([_column(trace, begin, last) for trace in traces], _stamp))
        begin = stop


def _column(trace: Optional[Recorded], start: float, end: float) -> CsvColumn:
    if trace is None:
        return CsvColumn("", _NOTHING, _NOTHING, ())
    times, values = trace.samples(start, end)
    cells = [repr(value) for value in values.tolist()]  # with all of its digits
    return CsvColumn(trace.stream.topic, times, trace.received(start, end), cells)


def _stamp(time: float, received: float) -> str:
    return f"{time!r},{received!r}"
