"""Make a CSV file of what is recorded, bit by bit."""

from typing import AsyncIterator, Sequence

import numpy

from topic_scope.csv_rows import Column, header, rows
from topic_scope.recorder import Recorder

#: Length of a part, s; frames are sent in between.
PART_S = 0.25


async def parts(
    recorder: Recorder, names: Sequence[str], start: float, end: float
) -> AsyncIterator[str]:
    """Return the parts of a file.

    :param recorder: has the samples
    :param names: names of the fields
    :param start: begin of the time span, s
    :param end: end of the time span, s
    """
    now = recorder.update()
    begin, end = max(start, now - recorder.history), min(end, now)
    yield header(names)
    while begin <= end:
        stop = begin + PART_S
        last = min(end, float(numpy.nextafter(stop, begin)))
        columns = [
            Column(recorder.topic_of(name), recorder.samples(name, begin, last)) for name in names
        ]
        yield "".join(rows(columns))
        begin = stop
