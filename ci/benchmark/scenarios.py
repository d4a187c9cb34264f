"""Which callbacks overlap, in the same scenarios with nodekit and with rclpy.

Two calls of a service come at once, to a node whose timer ticks meanwhile. For each scenario two
things can be observed: how many calls are answered at once, and whether the timer ticks during the
first. The programs that observe it import this module, with nodekit or with rclpy.
"""

import threading
import time
from typing import Any, List, NamedTuple

CALL_S, TICK_S = 0.5, 0.05


class Scenario(NamedTuple):
    """An executor, and the groups of the timer and of the service."""

    threads: int
    #: whether both are in one group
    shared: bool
    #: whether the service's group is reentrant
    reentrant: bool
    #: calls answered at once, and whether the timer ticks
    expected: List[int]


SCENARIOS = {
    "one thread": Scenario(1, True, True, [1, 0]),
    "one exclusive group": Scenario(4, True, False, [1, 0]),
    "two exclusive groups": Scenario(4, False, False, [1, 1]),
    "exclusive timer, reentrant service": Scenario(4, False, True, [2, 1]),
    "one reentrant group": Scenario(4, True, True, [2, 1]),
    "one reentrant group, two threads": Scenario(2, True, True, [2, 0]),
}


class Observation:
    """What is seen of one scenario."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = self._most = self._ticks = self._calls = 0
        self._ticks_in_first = 0

    def tick(self, *_: Any) -> None:
        """Be the timer's callback."""
        self._ticks += 1

    def serve(self) -> None:
        """Be what the service does."""
        with self._lock:
            self._calls += 1
            is_first = self._calls == 1
            self._inside += 1
            self._most = max(self._most, self._inside)
        before = self._ticks
        time.sleep(CALL_S)
        with self._lock:
            self._inside -= 1
            if is_first:
                self._ticks_in_first = self._ticks - before

    def result(self) -> List[int]:
        """Return how many calls were answered at once, and whether the timer ticked."""
        # A tick may be just under way when the call begins.
        return [self._most, int(self._ticks_in_first > 1)]
