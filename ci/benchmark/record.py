"""A record of samples in a file: for each its moment on the monotonic clock in s, and its value."""

import array
import mmap
import pathlib
import time
from typing import Any, List, NamedTuple

#: How many numbers a record has room for, two for each sample; the rest of it is 0.
ROOM = 1 << 20
_BYTES = 8 * ROOM


class Sample(NamedTuple):
    """A value and when it was sent or received, on the machine's monotonic clock [s]."""

    moment: float
    value: float


class Record:
    """Writer of samples to a file that others read meanwhile, at the least cost.

    :param file: its path; an existing file is overwritten
    """

    def __init__(self, file: str) -> None:
        with open(file, "w+b") as out:
            out.truncate(_BYTES)
            self._numbers: Any = memoryview(mmap.mmap(out.fileno(), _BYTES)).cast("d")
        self._next = 0

    def add(self, value: float) -> None:
        """Record a value with the present moment."""
        moment, at = time.monotonic(), self._next
        self._numbers[at + 1] = value
        self._numbers[at] = moment  # last, as it shows that the sample is complete
        self._next = at + 2


def read(file: pathlib.Path) -> List[Sample]:
    """Return the samples recorded so far; none before the file exists."""
    if not file.exists():
        return []
    numbers = array.array("d")
    data = file.read_bytes()
    numbers.frombytes(data[: len(data) - len(data) % 16])
    moments = numbers[::2]
    count = moments.index(0.0) if 0.0 in moments else len(moments)
    return [Sample(*pair) for pair in zip(moments[:count], numbers[1 : 2 * count : 2])]
