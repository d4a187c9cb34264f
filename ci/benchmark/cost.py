"""What processes cost: processor time and memory, those below them found."""

import contextlib
import pathlib
import time
from typing import Dict, Iterable, List


def cpu_time(pids: Iterable[int]) -> float:
    """Return the processor time that processes have used so far, s; 0 of those that are gone."""
    seconds = 0.0
    for pid in pids:
        with contextlib.suppress(OSError):
            seconds += time.clock_gettime(cpu_clock(pid))
    return seconds


def cpu_clock(pid: int) -> int:
    """Return the clock of the processor time of another process, its ended threads included.

    It is read at once, unlike the files of its threads, which may come and go meanwhile.
    """
    return ~pid << 3 | 2  # as clock_getcpuclockid(3) of Linux's C libraries makes it


def cpu_share(pids: List[int], seconds: float) -> float:
    """Watch for a while how much of one core processes use, %."""
    began, used = time.monotonic(), cpu_time(pids)
    time.sleep(seconds)
    return 100.0 * (cpu_time(pids) - used) / (time.monotonic() - began)


def resident_memory(pids: Iterable[int]) -> float:
    """Return the resident set of processes together, MB."""
    kilobytes = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
                if line.startswith("VmRSS:"):
                    kilobytes += int(line.split()[1])
    return kilobytes / 1024.0


def descendants(pid: int) -> List[int]:
    """Return the numbers of all processes below one."""
    parents: Dict[int, int] = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            # The name in parentheses may hold anything; the parent is the second field after it.
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    found: List[int] = []
    wanted = [pid]
    while wanted:
        children = [child for child, parent in parents.items() if parent in wanted]
        found += children
        wanted = children
    return found
