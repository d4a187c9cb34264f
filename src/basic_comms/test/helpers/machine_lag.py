"""Scheduling delay of this machine, for which a bound on time must allow."""

import contextlib
import threading
import time
from typing import Iterator

_NAP_S = 0.005


class Lag:
    """Thread that only sleeps, in parallel with a measurement.

    :ivar longest: its largest delay [s]
    """

    def __init__(self) -> None:
        self.longest = 0.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._sleep, daemon=True)
        self._thread.start()

    def _sleep(self) -> None:
        while not self._end.is_set():
            before = time.monotonic()
            time.sleep(_NAP_S)
            self.longest = max(self.longest, time.monotonic() - before - _NAP_S)

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


@contextlib.contextmanager
def measured_lag() -> Iterator[Lag]:
    """Measure as long as the context lasts."""
    lag = Lag()
    try:
        yield lag
    finally:
        lag.close()
