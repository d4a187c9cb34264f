"""Scheduling delay of this machine, for which a bound on time must allow."""

import contextlib
import os
import threading
import time
from typing import Callable, Dict, Iterable, Iterator

_NAP_S = 0.005
#: Interval of the checks how long threads waited for a processor [s].
_CHECK_S = 0.1


class Lag:
    """Thread that only sleeps, in parallel with a measurement.

    A single process may be delayed while others run: the longest wait of its threads for a
    processor counts too, as Linux measures it.

    :param pids: returns the measured processes in addition to this one

    :ivar longest: largest delay [s]
    """

    def __init__(self, pids: Callable[[], Iterable[int]]) -> None:
        self._pids = pids
        self._end = threading.Event()
        self._waits: Dict[str, float] = {}
        self.longest = 0.0
        self._check()
        self.longest = 0.0  # threads have waited before
        self._thread = threading.Thread(target=self._sleep, daemon=True)
        self._thread.start()

    def _sleep(self) -> None:
        checked_at = time.monotonic()
        while not self._end.is_set():
            before = time.monotonic()
            time.sleep(_NAP_S)
            now = time.monotonic()
            self.longest = max(self.longest, now - before - _NAP_S)
            if now - checked_at > _CHECK_S:
                checked_at = now
                self._check()

    def _check(self) -> None:
        """Compare each thread's wait so far with that at the previous check."""
        for pid in (os.getpid(), *self._pids()):
            waits = processor_waits(pid)
            for thread, wait in waits.items():
                self.longest = max(self.longest, wait - self._waits.get(thread, 0.0))
            self._waits.update(waits)

    def allowed(self, seconds: float) -> float:
        """Return a bound for this machine.

        :param seconds: the bound on an idle machine [s]
        """
        # A measurement passes through several processes, each of which may be delayed.
        return seconds + 4.0 * self.longest

    def close(self) -> None:
        """End the loop."""
        self._end.set()
        self._thread.join()
        self._check()


def processor_waits(pid: int) -> Dict[str, float]:
    """Return how long each thread of a process has waited for a processor [s].

    :param pid: process id
    :returns: time by thread; empty if the process has ended, or the kernel does not measure it
    """
    waits = {}
    with contextlib.suppress(OSError):
        for thread in os.listdir(f"/proc/{pid}/task"):
            with contextlib.suppress(OSError), open(f"/proc/{pid}/task/{thread}/schedstat") as text:
                waits[thread] = 1e-9 * float(text.read().split()[1])
    return waits


@contextlib.contextmanager
def measured_lag(pids: Callable[[], Iterable[int]] = tuple) -> Iterator[Lag]:
    """Measure as long as the context lasts.

    :param pids: returns the measured processes in addition to this one
    """
    lag = Lag(pids)
    try:
        yield lag
    finally:
        lag.close()
