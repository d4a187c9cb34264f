"""What processes hold of the machine: memory, threads, descriptors; and whether it grows."""

import contextlib
import pathlib
import statistics
import threading
import time
from typing import Dict, List, NamedTuple, Sequence


class Usage(NamedTuple):
    """What one process holds at a moment."""

    #: resident set, kB
    memory: int
    threads: int
    descriptors: int


def usage(pid: int) -> Usage:
    """Look at a process.

    :raises OSError: if it is gone
    """
    place = pathlib.Path(f"/proc/{pid}")
    status = dict(
        line.split(":", 1) for line in (place / "status").read_text().splitlines() if ":" in line
    )
    descriptors = len(list((place / "fd").iterdir()))
    memory = int(status.get("VmRSS", "0 kB").split()[0])
    return Usage(memory, int(status["Threads"]), descriptors)


def growth(values: Sequence[float]) -> float:
    """Return by what part the last tenth of a series lies above the first one, 0.01 for 1 %.

    Medians are compared: a peak that is taken back is no growth.
    """
    tenth = max(1, len(values) // 10)
    before = statistics.median(values[:tenth])
    return statistics.median(values[-tenth:]) / before - 1.0


def added(values: Sequence[int]) -> int:
    """Return by how much the least of the last tenth lies above the most of the first one."""
    tenth = max(1, len(values) // 10)
    return min(values[-tenth:]) - max(values[:tenth])


class Sampler:
    """Looks at processes once a second.

    :param pids: their numbers, by name
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


def settled_usage(pid: int, seconds: float = 3.0) -> Usage:
    """Look at a process for a while, and return the median of each figure."""
    seen: List[Usage] = []
    give_up = time.monotonic() + seconds
    while not seen or time.monotonic() < give_up:
        seen.append(usage(pid))
        time.sleep(0.1)
    columns = [int(statistics.median(column)) for column in zip(*seen)]
    return Usage(*columns)


def size_of(directory: pathlib.Path) -> int:
    """Return how long the files below a directory are together, bytes."""
    total = 0
    for path in directory.rglob("*"):
        with contextlib.suppress(OSError):
            if path.is_file() and not path.is_symlink():
                total += path.stat().st_size
    return total
