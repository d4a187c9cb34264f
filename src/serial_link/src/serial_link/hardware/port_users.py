"""Search in /proc for other processes that have a serial port open."""

import os
from typing import List, NamedTuple

_LONGEST = 80


class PortUser(NamedTuple):
    """A process that has a file open."""

    pid: int
    command: str

    def __str__(self) -> str:
        return f"process {self.pid} ({self.command})"


def find_port_users(path: str) -> List[PortUser]:
    """Return the other processes that have a file open, as far as this user may see them.

    Files are compared by inode, not by name: in a container, or with another /dev/pts, the names
    may differ. A process that created a pseudo terminal may keep it open, as simulators do: it is
    the board itself, and is not returned.

    :param path: of the file; links are followed
    """
    try:
        target = os.stat(path)
    except OSError:  # it was unplugged
        return []
    found = []
    for entry in os.listdir("/proc"):
        if not entry.isdecimal() or int(entry) == os.getpid() or not _has_open(entry, target):
            continue
        if not _has_made(entry, os.path.realpath(path)):
            found.append(PortUser(int(entry), _command(entry)))
    return found


def _has_open(pid: str, target: os.stat_result) -> bool:
    folder = f"/proc/{pid}/fd"
    try:
        return any(_points_to(f"{folder}/{number}", target) for number in os.listdir(folder))
    except OSError:  # it has ended, or belongs to another user
        return False


def _has_made(pid: str, path: str) -> bool:
    """Return whether a process has the other end of a pseudo terminal."""
    folder, _, number = path.rpartition("/")
    if folder != "/dev/pts":
        return False
    try:
        return any(
            f"tty-index:\t{number}\n" in _content(f"/proc/{pid}/fdinfo/{fd}")
            for fd in os.listdir(f"/proc/{pid}/fdinfo")
        )
    except OSError:
        return False


def _content(path: str) -> str:
    try:
        with open(path, encoding="ascii", errors="replace") as file:
            return file.read()
    except OSError:  # it was closed meanwhile
        return ""


def _points_to(link: str, target: os.stat_result) -> bool:
    try:
        return os.path.samestat(os.stat(link), target)
    except OSError:
        return False


def _command(pid: str) -> str:
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            words = file.read().decode("utf-8", "replace").strip("\0").split("\0")
    except OSError:
        return "ended just now"
    text = " ".join(words)
    if len(text) > _LONGEST:  # the folders are the least informative part
        text = " ".join(os.path.basename(word) for word in words)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
