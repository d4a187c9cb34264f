"""Exception that ended a Python controller, found in its output."""

import os
import re
from typing import List, Sequence, Tuple

_FRAME = re.compile(r'  File "(.+)", line (\d+)')
_EXCEPTION = re.compile(r"[A-Za-z_][\w.]*(: .*)?$")
#: Folders of installed modules, which may lie below a user's folder.
_INSTALLED = re.compile(r"/(site|dist)-packages/")


def crash_in(output: str, argv: Sequence[str]) -> str:
    """Return the latest exception with the innermost line of the student's code; empty if none.

    :param output: output of the controller
    :param argv: the controller and its arguments
    """
    crash = ""
    frames: List[Tuple[str, str]] = []
    for line in output.splitlines():
        frame = _FRAME.match(line)
        if frame is not None:
            frames.append((frame.group(1), frame.group(2)))
        elif frames and _EXCEPTION.match(line):
            crash, frames = line + _place(frames, argv), []
    return crash


def _place(frames: Sequence[Tuple[str, str]], argv: Sequence[str]) -> str:
    files = [word for word in argv if os.path.isfile(word)]
    # catkin builds a program of the same name that executes the controller.
    names = [os.path.basename(path) for path in files]
    files += [path for path, _ in frames if os.path.basename(path) in names]
    folders = [_package(path) for path in files]
    for path, line in reversed(frames):
        is_installed = not os.path.isabs(path) or _INSTALLED.search(path)
        if not is_installed and _package(path) in folders:
            return f" ({os.path.basename(path)}, line {line})"
    return ""


def _package(path: str) -> str:
    """Return the folder of the package that a file is in, or else of the file."""
    own = folder = os.path.dirname(os.path.realpath(path))
    while folder != os.path.dirname(folder):
        if os.path.isfile(os.path.join(folder, "package.xml")):
            return folder
        folder = os.path.dirname(folder)
    return own
