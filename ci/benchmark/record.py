"""A record of samples in a file: for each its moment on the monotonic clock in s, and its value."""

import array
import pathlib
import time
from typing import List

from analysis import Sample


class Record:
    """Keeps samples in memory, at the least cost, until they are written to a file."""

    def __init__(self) -> None:
        self._numbers = array.array("d")

    def add(self, value: float) -> None:
        """Keep a sample of this moment."""
        self._numbers.append(time.monotonic())
        self._numbers.append(value)

    def write(self, file: str) -> None:
        """Write all samples there are."""
        with open(file, "wb") as out:
            self._numbers.tofile(out)


def read(file: pathlib.Path) -> List[Sample]:
    """Return the samples that a process has written.

    :raises FileNotFoundError: if it has not come to that
    """
    numbers = array.array("d", file.read_bytes())
    return [Sample(*pair) for pair in zip(numbers[::2], numbers[1::2])]
