"""Replay of a recorded signal: a CSV file of times and values."""

import math
import os
from array import array
from bisect import bisect_right
from typing import Iterable, List, Optional, Tuple

#: Most rows and bytes that are read, so that a wrong file cannot fill the memory.
LARGEST_ROWS = 1_000_000
LARGEST_BYTES = 64 * 2**20

#: A held row and the end of a loop count as reached this long before their time, s: sample times
#: are rounded, so one that falls on a row would otherwise land on either side of it by chance.
_EARLY = 1e-9


class SeriesError(ValueError):
    """A file that cannot be replayed; the text says where and what is allowed."""


class Series:
    """A recorded signal: values in [-1, 1] at strictly increasing times. It never changes.

    The values are divided by the largest magnitude among them, the :attr:`peak`. Played with an
    amplitude equal to the peak, the signal is the recorded one.

    :param times: times of the rows, s; only their differences matter
    :param values: values of the rows, as many
    :raises ValueError: if there are no rows
    """

    def __init__(self, times: Iterable[float], values: Iterable[float]) -> None:
        self._times = array("d", times)
        self._values = array("d", values)
        if not self._times or len(self._times) != len(self._values):
            raise ValueError("a series needs rows of one time and one value each")
        self.peak = max(abs(value) for value in self._values)
        if self.peak:
            self._values = array("d", (value / self.peak for value in self._values))
        first = self._times[0]
        self._times = array("d", (time - first for time in self._times))

    def __len__(self) -> int:
        return len(self._times)

    @property
    def duration(self) -> float:
        """Time from the first row to the last, s."""
        return self._times[-1]

    def value(self, elapsed: float, hold: bool, loop: bool) -> float:
        """Return the signal at a time.

        Before the first row and beyond the last their values stay, unless the signal loops: then
        the time of the last row is that of the first again.

        :param elapsed: time since the first row, s
        :param hold: keep each value until the next row, instead of interpolating linearly
        :param loop: start again at the last row
        :returns: value in [-1, 1]
        """
        if loop and self.duration:
            elapsed = (elapsed + _EARLY) % self.duration - _EARLY
        row = bisect_right(self._times, elapsed + _EARLY if hold else elapsed) - 1
        if row < 0:
            return self._values[0]
        if hold or row == len(self) - 1:
            return self._values[row]
        before, after = self._times[row], self._times[row + 1]
        rise = self._values[row + 1] - self._values[row]
        return self._values[row] + rise * ((elapsed - before) / (after - before))


def load_series(path: str) -> Series:
    """Read a recorded signal from a CSV file.

    Each line holds a time in s and a value, separated by a comma. Blank lines and lines that start
    with ``#`` count for nothing; the first other line may be a heading.

    :param path: path of the file; ``~`` stands for the home directory
    :returns: the signal
    :raises SeriesError: if the file is missing, too big or not of this form
    """
    full_path = os.path.expanduser(path)
    if not os.path.isfile(full_path):
        raise SeriesError(f"{path!r}: there is no such file; a CSV file of time,value is needed")
    try:
        if os.path.getsize(full_path) > LARGEST_BYTES:
            raise SeriesError(f"{path}: too big; at most {LARGEST_BYTES} bytes are allowed")
        with open(full_path, encoding="utf-8-sig") as lines:
            times, values = _read_rows(path, lines)
    except OSError as error:
        raise SeriesError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SeriesError(f"{path}: not UTF-8 text; a CSV file of time,value is needed") from error
    if not times:
        raise SeriesError(f"{path}: no rows; at least one line of time,value is needed")
    return Series(times, values)


def _read_rows(path: str, lines: Iterable[str]) -> "Tuple[array[float], array[float]]":
    """Return the times and the values of all rows, checked."""
    times, values = array("d"), array("d")
    heading_allowed = True
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        fields = [_number(field) for field in text.split(",")]
        if heading_allowed and not any(field is not None for field in fields):
            heading_allowed = False
            continue
        heading_allowed = False
        time, value = _row(f"{path}, line {number}", text, fields)
        if times and not times[-1] < time:
            raise SeriesError(
                f"{path}, line {number}: time {time!r} after {times[-1]!r}; "
                "times must increase from line to line"
            )
        if len(times) == LARGEST_ROWS:
            raise SeriesError(
                f"{path}, line {number}: too long; at most {LARGEST_ROWS} rows are allowed"
            )
        times.append(time)
        values.append(value)
    return times, values


def _number(field: str) -> Optional[float]:
    try:
        return float(field)
    except ValueError:
        return None


def _row(where: str, text: str, fields: List[Optional[float]]) -> Tuple[float, float]:
    """Return the time and the value of one line."""
    if len(fields) == 2 and fields[0] is not None and fields[1] is not None:
        if math.isfinite(fields[0]) and math.isfinite(fields[1]):
            return fields[0], fields[1]
    shown = text if len(text) <= 40 else text[:37] + "..."
    raise SeriesError(f"{where}: {shown!r}; two finite numbers, time,value, are allowed")
