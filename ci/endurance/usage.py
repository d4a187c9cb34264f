"""Memory, threads and descriptors of processes, and their growth."""

import contextlib
import pathlib
import threading
import time
from typing import Dict, List, NamedTuple, Sequence

import numpy as np

from ..benchmark.cost import status
from .checks import Check, at_most, reported


class Usage(NamedTuple):
    """Resources of one process at a moment."""

    #: resident set [kB]
    memory: int
    threads: int
    descriptors: int


def usage(pid: int) -> Usage:
    """Return what a process uses.

    :raises OSError: if it has ended
    """
    fields = status(pid)
    descriptors = len(list(pathlib.Path(f"/proc/{pid}/fd").iterdir()))
    return Usage(int(fields.get("VmRSS", "0 kB").split()[0]), int(fields["Threads"]), descriptors)


def settled_usage(pid: int, seconds: float = 3.0) -> Usage:
    """Observe a process for a while, and return the median of each figure."""
    seen: List[Usage] = []
    give_up = time.monotonic() + seconds
    while not seen or time.monotonic() < give_up:
        seen.append(usage(pid))
        time.sleep(0.1)
    return Usage(*map(int, np.median(seen, axis=0)))


def growth(values: Sequence[float]) -> float:
    """Return by how much the last tenth of a series lies above the first one [%].

    Medians are compared: a peak that is taken back is not growth.
    """
    tenth = max(1, len(values) // 10)
    before, after = np.median(values[:tenth]), np.median(values[-tenth:])
    return round(float(100.0 * (after / before - 1.0)), 2)


def added(values: Sequence[int]) -> int:
    """Return by how much the least of the last tenth lies above the most of the first one."""
    tenth = max(1, len(values) // 10)
    return min(values[-tenth:]) - max(values[:tenth])


def not_grown(name: str, seen: List[Usage], limit: float = 1.0) -> List[Check]:
    """Check that memory, threads and descriptors of a process stay what they were.

    :param seen: its usage, in the order of time
    :param limit: of the memory's growth [%]
    """
    memory = [one.memory for one in seen]
    return [
        reported(
            "memory of " + name, f"{memory[0] / 1024:.1f} MB, then {memory[-1] / 1024:.1f} MB"
        ),
        at_most("its growth", growth(memory), limit, "%"),
        at_most("its new threads", added([one.threads for one in seen]), 0),
        at_most("its new descriptors", added([one.descriptors for one in seen]), 0),
    ]


class Sampler:
    """Reads what processes use, once a second, for the duration of its context.

    :param pids: process ids by name
    """

    PERIOD = 1.0

    def __init__(self, pids: Dict[str, int]) -> None:
        self._pids = pids
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self.samples: Dict[str, List[Usage]] = {name: [] for name in pids}

    def __enter__(self) -> "Sampler":
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._done.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._done.wait(self.PERIOD):
            for name, pid in self._pids.items():
                with contextlib.suppress(OSError):
                    self.samples[name].append(usage(pid))


def size_of(directory: pathlib.Path) -> int:
    """Return the total length of the files below a directory [bytes]."""
    files = [path for path in directory.rglob("*") if path.is_file() and not path.is_symlink()]
    return sum(path.stat().st_size for path in files)
