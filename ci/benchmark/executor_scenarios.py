"""Scenarios of callbacks that may overlap, the same for nodekit and rclpy.

A service of a node is called twice at the same time while the node's timer ticks. Each scenario
shows how many calls are answered at the same time, and whether the timer ticks during the first.
"""

import json
import threading
import time
from typing import Any, Callable, List, NamedTuple

CALL_S, TICK_S = 0.5, 0.05


class Scenario(NamedTuple):
    """An executor, and the groups of the timer and of the service."""

    threads: int
    #: whether both are in one group
    is_shared: bool
    #: whether the service's group is reentrant
    is_reentrant: bool
    #: number of calls answered at the same time, and whether the timer ticks
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
    """Record of one scenario; its methods are the callbacks."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = self._most = self._ticks = self._calls = 0
        self._ticks_in_first = 0

    def tick(self, *_: Any) -> None:
        """Count a tick of the timer."""
        self._ticks += 1

    def serve(self) -> None:
        """Answer a call of the service, slowly."""
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
        """Return how many calls were answered at the same time, and whether the timer ticked."""
        # A tick may be in progress when the call begins.
        return [self._most, int(self._ticks_in_first > 1)]


def print_all(run: Callable[[int, Scenario, Observation], None]) -> None:
    """Print the observations of all scenarios, as JSON.

    :param run: runs the scenario of a number, with the callbacks of an observation
    """
    seen = {}
    for number, (name, scenario) in enumerate(SCENARIOS.items()):
        observation = Observation()
        run(number, scenario, observation)
        seen[name] = observation.result()
    print(json.dumps(seen), flush=True)
