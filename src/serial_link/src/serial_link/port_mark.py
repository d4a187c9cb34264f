"""Mark file beside the symbolic link to a simulated board's port, to detect stale links.

A killed board leaves its link behind, and the system reuses the terminal's number for the next
program. The folder may be world-writable, so a mark may be another user's file.
"""

import contextlib
import os
import re
import stat
from typing import List

_ENDING = ".board"
#: Process id, start time, pid namespace, and terminal.
_MARK = re.compile(r"([1-9][0-9]{0,9}) ([0-9]{1,20}) (\S+) (\S+)\n")
#: Longest mark [bytes].
_LONGEST = 200
#: Index of the start time among the fields of /proc/PID/stat after the command.
_BEGAN = 19


def write_mark(link: str) -> None:
    """Mark a link as owned by this process, replacing another mark.

    :param link: its path
    :raises OSError: if the mark cannot be written
    """
    remove_mark(link)
    # A new file: an existing link of another user would redirect the write to its target.
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    with open(os.open(link + _ENDING, flags, 0o644), "w", encoding="utf-8") as file:
        file.write(_own_mark(os.readlink(link)))


def remove_mark(link: str) -> None:
    """Remove the mark of a link, if there is one.

    :param link: its path
    """
    with contextlib.suppress(OSError):
        os.unlink(link + _ENDING)


def is_left_behind(link: str) -> bool:
    """Return whether the process that created a link has ended.

    :param link: its path
    :returns: False also if that is unknown: without a valid mark of the link's owner, or if the
        system hides the process
    """
    found = _MARK.fullmatch(_mark(link))
    if found is None or found[3] != _namespace() or _target(link) != found[4]:
        return False
    return _has_ended(int(found[1]), found[2])


def remove_link(link: str) -> None:
    """Remove a link and its mark.

    :param link: its path
    """
    remove_mark(link)
    with contextlib.suppress(OSError):
        os.unlink(link)


def remove_own_link(link: str, terminal: str) -> None:
    """Remove a link and its mark, if they still belong to this process.

    :param link: its path
    :param terminal: target of this process's link; empty if it created none
    """
    if not terminal:
        return
    if _target(link) == terminal:
        remove_link(link)
    elif _mark(link) == _own_mark(terminal):
        remove_mark(link)


def _own_mark(terminal: str) -> str:
    return f"{os.getpid()} {_began(os.getpid())} {_namespace()} {terminal}\n"


def _mark(link: str) -> str:
    """Return the text of a mark; empty unless it is a file of the link's owner."""
    try:
        # Without O_NONBLOCK, a FIFO would block.
        flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        file = os.open(link + _ENDING, flags)
    except OSError:
        return ""
    try:
        status = os.fstat(file)
        if not stat.S_ISREG(status.st_mode) or status.st_size > _LONGEST:
            return ""
        if os.path.lexists(link) and status.st_uid != os.lstat(link).st_uid:
            return ""
        return os.read(file, _LONGEST).decode(errors="replace")
    except OSError:
        return ""
    finally:
        os.close(file)


def _target(link: str) -> str:
    """Return the target of a link; empty if it is not a link."""
    try:
        return os.readlink(link)
    except OSError:
        return ""


def _namespace() -> str:
    """Return the pid namespace of this process; empty if unknown."""
    return _target("/proc/self/ns/pid")


def _has_ended(pid: int, began: str) -> bool:
    """Return whether a process has ended; False if its start time cannot be read."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except OverflowError:  # not a valid process number
        return False
    except PermissionError:  # another user's process: it exists
        pass
    return _began(pid) not in ("", began)


def _began(pid: int) -> str:
    """Return the start time of a process, by the system's clock; empty if it cannot be read."""
    words = " ".join(_words(f"/proc/{pid}/stat")).rpartition(")")[2].split()
    return words[_BEGAN] if len(words) > _BEGAN else ""


def _words(path: str) -> List[str]:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read().split()
    except OSError:
        return []
