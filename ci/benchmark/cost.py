"""Processor time and memory of processes, and the processes that they started."""

import contextlib
import pathlib
import time
from typing import Dict, Iterable, List


def cpu_time(pids: Iterable[int]) -> float:
    """Return the processor time of processes so far [s]; 0 for those that have ended."""
    seconds = 0.0
    for pid in pids:
        with contextlib.suppress(OSError):
            # The process's clock, as clock_getcpuclockid(3) of Linux's C libraries makes it. It is
            # read at once, and includes threads that have ended, unlike the files in /proc.
            seconds += time.clock_gettime(~pid << 3 | 2)
    return seconds


def cpu_share(pids: List[int], seconds: float) -> float:
    """Return how much of one core processes use during the next seconds [%]."""
    began, used = time.monotonic(), cpu_time(pids)
    time.sleep(seconds)
    return 100.0 * (cpu_time(pids) - used) / (time.monotonic() - began)


def status(pid: int) -> Dict[str, str]:
    """Return the fields of /proc/PID/status.

    :raises OSError: if the process has ended
    """
    lines = pathlib.Path(f"/proc/{pid}/status").read_text().splitlines()
    return dict(line.split(":", 1) for line in lines if ":" in line)


def resident_mb(pid: int) -> float:
    """Return the resident set of a process [MB]; 0 if it has ended."""
    with contextlib.suppress(OSError):
        return int(status(pid).get("VmRSS", "0 kB").split()[0]) / 1024.0
    return 0.0


def stat_fields(number: int) -> Dict[int, int]:
    """Return a field of /proc/PID/stat of each process, by number, the state being the first."""
    fields: Dict[int, int] = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            # The name in parentheses may hold anything.
            values = stat.read_text().rpartition(")")[2].split()
            fields[int(stat.parent.name)] = int(values[number])
    return fields


def descendants(pid: int) -> List[int]:
    """Return the processes that a process and its children have started."""
    parents, found, wanted = stat_fields(1), [], [pid]
    while wanted:
        wanted = [child for child, parent in parents.items() if parent in wanted]
        found += wanted
    return found


def with_variable(variable: str) -> List[int]:
    """Return the processes that were started with NAME=VALUE in their environments."""
    found = []
    for environ in pathlib.Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if variable.encode() in environ.read_bytes().split(b"\0"):
                found.append(int(environ.parent.name))
    return found
