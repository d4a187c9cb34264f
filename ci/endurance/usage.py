"""Growth of processes' resource usage."""

import contextlib
import threading
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from ..benchmark.cost import Usage, usage
from .checks import Check, at_most, reported


def ends(values: Sequence[float], typical: Any = np.median, parts: int = 10) -> Tuple[float, float]:
    """Return the typical values of the first and of the last part of a series.

    :param typical: value of a part; the median ignores temporary peaks
    :param parts: number of parts
    """
    length = max(1, len(values) // parts)
    return float(typical(values[:length])), float(typical(values[-length:]))


def growth(values: Sequence[float], typical: Any = np.median, parts: int = 10) -> float:
    """Return the growth of a series between its :func:`ends` [%]."""
    before, after = ends(values, typical, parts)
    return round(100.0 * (after / before - 1.0), 2)


def added(values: Sequence[int]) -> int:
    """Return the smallest value of the last tenth minus the largest of the first."""
    tenth = max(1, len(values) // 10)
    return min(values[-tenth:]) - max(values[:tenth])


def not_grown(
    name: str, seen: List[Usage], limit: float = 1.0, typical: Any = np.median
) -> List[Check]:
    """Check that memory, threads and descriptors of a process do not grow.

    :param seen: its usage over time
    :param limit: of the memory's growth [%]
    :param typical: value of a part of the time, see :func:`ends`
    """
    memory, threads, descriptors = zip(*seen)
    before, after = (kilobytes / 1024.0 for kilobytes in ends(memory, typical))
    return [
        reported("memory of " + name, f"{before:.1f} MB, then {after:.1f} MB"),
        at_most("its growth", growth(memory, typical), limit, "%"),
        at_most("its new threads", added(threads), 0),
        at_most("its new descriptors", added(descriptors), 0),
    ]


class Sampler:
    """Sampler of processes' usage, once a second, for the duration of its context.

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
