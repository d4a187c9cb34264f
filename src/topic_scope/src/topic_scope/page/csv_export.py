"""CSV export of recorded samples, in parts."""

from typing import AsyncIterator, Optional, Sequence

import numpy

from topic_scope.analysis.csv_rows import CsvColumn, header, quoted, rows
from topic_scope.sampling.computed_trace import Recorded
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, exact_seconds, to_ns

#: Length of a part [ns]; frames are sent between parts.
_PART_NS = NS // 4
#: Larger than the rounding of a time since the epoch [s].
_MORE_S = 1e-6

_NOTHING = numpy.empty(0, numpy.int64)


async def parts(
    recorder: Recorder, names: Sequence[str], start: float, end: float
) -> AsyncIterator[str]:
    """Return the parts of a file.

    :param recorder: recorder of the samples
    :param names: names of the fields
    :param start: start of the time span [s]
    :param end: end of the time span [s]
    """
    recorder.update()
    spans = [trace.span for trace in map(recorder.trace, names) if trace and trace.span]
    begin = to_ns(max(start, min([first for first, _ in spans], default=end)) - _MORE_S)
    end_ns = to_ns(min(end, max([last for _, last in spans], default=start) + _MORE_S))
    begin = max(begin, to_ns(start))
    yield header("time", "received", *names)
    while begin <= end_ns:
        last = min(end_ns, begin + _PART_NS - 1)
        traces = [recorder.trace(name) for name in names]
        yield "".join(rows([_column(trace, begin, last) for trace in traces], _stamp))
        begin = last + 1


def _column(trace: Optional[Recorded], start: int, end: int) -> CsvColumn:
    if trace is None:
        return CsvColumn("", _NOTHING, _NOTHING, ())
    times, values, received = trace.rows(start, end)
    cells = [repr(value) for value in values.tolist()]  # with all of its digits
    if trace.states is not None:
        texts = map(trace.states.text, values.tolist())
        cells = [cell if text is None else quoted(text) for cell, text in zip(cells, texts)]
    return CsvColumn(trace.stream.topic, times, received, cells)


def _stamp(time: int, received: int) -> str:
    return f"{exact_seconds(time)},{exact_seconds(received)}"
