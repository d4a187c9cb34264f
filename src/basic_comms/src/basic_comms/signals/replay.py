"""Replay of a recorded signal: a CSV file of times and values."""

import io
import math
import os
import stat
from array import array
from bisect import bisect_right
from typing import Iterable, Tuple

#: Most bytes and lines of a file. It is read in the thread that handles all parameters of the
#: process: at about 1 us a line, the others wait for at most 0.2 s.
LARGEST_BYTES = 8_000_000
LARGEST_LINES = 200_000

#: A held row and the end of a loop count as reached this long before their time [s]: sample times
#: are rounded, so a sample exactly on a row could otherwise fall on either side of it.
_EARLY = 1e-9


class SeriesError(ValueError):
    """A file that cannot be replayed; the text gives the position and the expected content."""


class Series:
    """Recorded signal: values in [-1, 1] at strictly increasing times; immutable.

    The values are divided by their largest magnitude, the :attr:`peak`. Played with an amplitude
    equal to the peak, the signal is the recorded one.

    :param times: times of the rows [s]; only their differences matter
    :param values: values of the rows, of the same number
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
        """Time from the first row to the last [s]."""
        return self._times[-1]

    def value(self, elapsed: float, hold: bool, loop: bool) -> float:
        """Return the signal at a time.

        Before the first row and after the last, the signal is constant, unless it loops: then the
        time of the last row is that of the first again.

        :param elapsed: time since the first row [s]
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

    Each line has a time [s] and a value, separated by a comma. Blank lines and lines that start
    with ``#`` are ignored; the first other line may be a heading, two names.

    :param path: path of the file; ``~`` is expanded to the home directory
    :returns: the signal
    :raises SeriesError: if the file is missing, too large or malformed
    """
    try:
        content = _content(path)
        times, values = _rows(path, io.TextIOWrapper(io.BytesIO(content), encoding="utf-8-sig"))
    except OSError as error:
        raise SeriesError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SeriesError(f"{path}: not UTF-8 text; a CSV file of time,value is needed") from error
    if not times:
        raise SeriesError(f"{path}: no rows; at least one line of time,value is needed")
    return Series(times, values)


def _content(path: str) -> bytes:
    """Return the content of a file; open only regular files up to the maximum size."""
    full_path = os.path.expanduser(path)
    try:
        status = os.stat(full_path)
    except (FileNotFoundError, ValueError) as error:  # ValueError: an invalid file name
        raise SeriesError(f"{path!r}: no such file; a CSV file of time,value is needed") from error
    if not stat.S_ISREG(status.st_mode):
        kind = _kind(status.st_mode)
        raise SeriesError(f"{path}: this is {kind}; a CSV file of time,value is needed")
    if status.st_size <= LARGEST_BYTES:
        with open(full_path, "rb") as file:
            content = file.read(LARGEST_BYTES + 1)  # files in /proc report size 0
        if len(content) <= LARGEST_BYTES:
            return content
    size = max(status.st_size, LARGEST_BYTES + 1)
    raise SeriesError(f"{path}: {size} bytes; at most {LARGEST_BYTES} are allowed")


def _kind(mode: int) -> str:
    """Return the name of a type of file."""
    if stat.S_ISDIR(mode):
        return "a folder"
    if stat.S_ISFIFO(mode):
        return "a FIFO"
    return "a socket" if stat.S_ISSOCK(mode) else "a device"


def _rows(path: str, lines: Iterable[str]) -> "Tuple[array[float], array[float]]":
    """Return the times and the values of all rows, validated."""
    times, values = array("d"), array("d")
    latest = -math.inf
    may_be_heading = True
    for number, line in enumerate(lines, start=1):
        if number > LARGEST_LINES:
            raise SeriesError(f"{path}: too long; at most {LARGEST_LINES} lines are allowed")
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        first, _, second = text.partition(",")
        try:
            time, value = float(first), float(second)
        except ValueError:
            if may_be_heading and _is_name(first) and _is_name(second):
                may_be_heading = False
                continue
            time = value = math.nan
        if not (math.isfinite(time) and math.isfinite(value)):
            shown = text if len(text) <= 40 else text[:37] + "..."
            raise SeriesError(
                f"{path}, line {number}: {shown!r}; two finite numbers, time,value, are allowed"
                + (", or a heading of two names" if may_be_heading else "")
            )
        if time <= latest:
            raise SeriesError(
                f"{path}, line {number}: time {time!r} after {latest!r}; "
                "times must increase from line to line"
            )
        may_be_heading = False
        latest = time
        times.append(time)
        values.append(value)
    return times, values


def _is_name(field: str) -> bool:
    """Return whether this may be the heading of a column: ``time [s]``, ``%time``, ``/a/b``."""
    return "," not in field and field.strip(" \t\"'%/~_")[:1].isalpha()
