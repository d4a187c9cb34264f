"""Processes and files that a command may leave behind."""

import pathlib
from typing import List


def processes_of(folder: str) -> List[str]:
    """Return the command lines of all processes with temporary files in a folder."""
    mark, found = f"TMPDIR={folder}".encode(), []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if mark in (process / "environ").read_bytes().split(b"\0"):
                found.append((process / "cmdline").read_bytes().decode())
        except OSError:
            continue  # it has just ended
    return found
