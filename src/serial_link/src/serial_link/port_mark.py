"""Mark beside the link to a simulated board's port: the process that made it.

A board that was killed leaves its link behind, and the system gives the terminal's number to the
next program that makes one. The folder may be everybody's, so a mark may be another user's file.
"""

import contextlib
import os
import re
import stat
from typing import List

_ENDING = ".board"
#: Process, when it began, its namespace of process numbers, and the terminal.
_MARK = re.compile(r"([1-9][0-9]{0,9}) ([0-9]{1,20}) (\S+) (\S+)\n")
#: Longest mark [bytes].
_LONGEST = 200
#: Of the fields of /proc/PID/stat behind the command: when the process began.
_BEGAN = 19


def write_mark(link: str) -> None:
    """Mark a link as this process's own, in place of another mark.

    :param link: its path
    :raises OSError: if the mark cannot be written
    """
    remove_mark(link)
    # A new file: where another user's link is, the file that it leads to would be overwritten.
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
    """Tell whether the process that made a link has ended.

    :param link: its path
    :returns: False also where that is unknown: without a valid mark of the link's owner, and where
        the system hides the process
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
    """Remove a link and its mark, as far as they are still this process's own.

    :param link: its path
    :param terminal: to which this process made it; empty if it has not
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
    """Return the text of a mark; empty unless it is a file of the owner of the link."""
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
    """Return where a link leads; empty if it is no link."""
    try:
        return os.readlink(link)
    except OSError:
        return ""


def _namespace() -> str:
    """Return the namespace of this process's numbers; empty if the system does not tell."""
    return _target("/proc/self/ns/pid")


def _has_ended(pid: int, began: str) -> bool:
    """Tell whether a process has ended; not where its beginning cannot be read."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except OverflowError:  # a number that no process has
        return False
    except PermissionError:  # another user's process: it is there
        pass
    return _began(pid) not in ("", began)


def _began(pid: int) -> str:
    """Return when a process began, by the system's clock; empty if that cannot be read."""
    words = " ".join(_words(f"/proc/{pid}/stat")).rpartition(")")[2].split()
    return words[_BEGAN] if len(words) > _BEGAN else ""


def _words(path: str) -> List[str]:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read().split()
    except OSError:
        return []
