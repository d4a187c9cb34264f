"""Processor time, memory, threads and descriptors of processes."""

import contextlib
import pathlib
import time
from typing import Iterable, List, NamedTuple


class Usage(NamedTuple):
    """Resources of one process at a moment."""

    #: resident set, without shared memory [kB]
    memory: int
    threads: int
    descriptors: int


def usage(pid: int) -> Usage:
    """Return the resource usage of a process.

    :raises OSError: if it has ended
    """
    process = pathlib.Path(f"/proc/{pid}")
    lines = (process / "status").read_text().splitlines()
    fields = dict(line.split(":", 1) for line in lines if ":" in line)
    own = (fields.get(name, "0 kB") for name in ("RssAnon", "RssFile"))
    memory = sum(int(text.split()[0]) for text in own)
    return Usage(memory, int(fields["Threads"]), len(list((process / "fd").iterdir())))


def cpu_time(pids: Iterable[int]) -> float:
    """Return the processor time of processes so far [s]; 0 for ended processes."""
    seconds = 0.0
    for pid in pids:
        with contextlib.suppress(OSError):
            # The id of the process's clock, as from clock_getcpuclockid(3). A read takes one call
            # and includes ended threads, unlike the files in /proc.
            seconds += time.clock_gettime(~pid << 3 | 2)
    return seconds


def cpu_share(pids: List[int], seconds: float) -> float:
    """Return the share of one core that processes use during the next seconds [%]."""
    began, used = time.monotonic(), cpu_time(pids)
    time.sleep(seconds)
    return 100.0 * (cpu_time(pids) - used) / (time.monotonic() - began)
