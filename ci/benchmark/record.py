"""Record of samples in a file: time on the monotonic clock [s], and value."""

import pathlib
import time
from typing import Any, List, NamedTuple

import numpy as np

#: Capacity of a record [samples]; unused entries are 0.
ROOM = 1 << 19


class Sample(NamedTuple):
    """A value and when it was sent or received, on the machine's monotonic clock [s]."""

    moment: float
    value: float


class Record:
    """Writer of samples to a file that others read meanwhile, at minimal cost.

    :param file: its path; an existing file is overwritten
    """

    def __init__(self, file: str) -> None:
        numbers: Any = np.memmap(file, "d", "w+", shape=2 * ROOM)
        self._numbers: Any = memoryview(numbers)  # quicker to write than an array
        self._next = 0

    def add(self, value: float) -> None:
        """Record a value with the present time."""
        moment, at = time.monotonic(), self._next
        self._numbers[at + 1] = value
        self._numbers[at] = moment  # last, as it shows that the sample is complete
        self._next = at + 2


def read(file: pathlib.Path) -> List[Sample]:
    """Return the samples recorded so far; empty before the file exists."""
    if not file.exists():
        return []
    numbers = np.fromfile(str(file))
    rows = numbers[: len(numbers) // 2 * 2].reshape(-1, 2)
    return [Sample(*row) for row in rows[: np.count_nonzero(rows[:, 0])].tolist()]
