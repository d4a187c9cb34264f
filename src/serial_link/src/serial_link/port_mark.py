"""Mark beside the link to a simulated board's port: the process that made it.

A board that was killed leaves its link behind, and the system gives the terminal's number to the
next program that makes one.
"""

import contextlib
import os
from typing import List

_ENDING = ".board"
#: Of the fields of /proc/PID/stat behind the command: when the process began.
_BEGAN = 19


def write_mark(link: str) -> None:
    """Mark a link as this process's own.

    :param link: its path
    :raises OSError: if the mark cannot be written
    """
    with open(link + _ENDING, "w", encoding="ascii") as file:
        file.write(f"{os.getpid()} {_began(os.getpid())} {os.readlink(link)}\n")


def remove_mark(link: str) -> None:
    """Remove the mark of a link, if there is one.

    :param link: its path
    """
    with contextlib.suppress(OSError):
        os.unlink(link + _ENDING)


def is_left_behind(link: str) -> bool:
    """Tell whether the process that made a link has ended; not without a mark.

    :param link: its path
    """
    words = _words(link + _ENDING)
    if len(words) != 3 or not words[0].isdecimal() or not os.path.islink(link):
        return False
    pid, began, terminal = words
    return os.readlink(link) == terminal and _began(int(pid)) != began


def remove_link(link: str) -> None:
    """Remove a link and its mark.

    :param link: its path
    """
    remove_mark(link)
    with contextlib.suppress(OSError):
        os.unlink(link)


def _began(pid: int) -> str:
    """Return when a process began, by the system's clock; empty if there is no such process."""
    words = " ".join(_words(f"/proc/{pid}/stat")).rpartition(")")[2].split()
    return words[_BEGAN] if len(words) > _BEGAN else ""


def _words(path: str) -> List[str]:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read().split()
    except OSError:
        return []
