"""A record of samples in a file: for each its moment on the monotonic clock in s, and its value."""

import array
import mmap
import pathlib
import time
from typing import Any, List

from .analysis import Sample

#: How many numbers a record has room for, two for each sample; the rest of it is 0.
ROOM = 1 << 20
_BYTES = 8 * ROOM


class Record:
    """Puts samples into a file that others read meanwhile, at the least cost.

    :param file: where to, made anew
    """

    def __init__(self, file: str) -> None:
        with open(file, "w+b") as out:
            out.truncate(_BYTES)
            self._numbers: Any = memoryview(mmap.mmap(out.fileno(), _BYTES)).cast("d")
        self._next = 0

    def add(self, value: float) -> None:
        """Keep a sample of this moment."""
        moment, at = time.monotonic(), self._next
        self._numbers[at + 1] = value
        self._numbers[at] = moment  # last, as it tells that the sample is there
        self._next = at + 2


def read(file: pathlib.Path) -> List[Sample]:
    """Return the samples that a process has put there so far.

    :raises FileNotFoundError: if it has not come to that
    """
    numbers = array.array("d")
    data = file.read_bytes()
    numbers.frombytes(data[: len(data) - len(data) % 16])
    moments = numbers[::2]
    count = moments.index(0.0) if 0.0 in moments else len(moments)
    return [Sample(*pair) for pair in zip(moments[:count], numbers[1 : 2 * count : 2])]
