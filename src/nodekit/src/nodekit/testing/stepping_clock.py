#!/usr/bin/env python3
"""Test program: runs a node with a wall clock that SIGUSR1 and SIGUSR2 set back or ahead an hour.

The machine's clock is unchanged: only Python code of the node reads the wrong time. The first
argument is the name of the node's module, e.g. ``basic_comms.nodes.talker``.
"""

import signal
import sys
import time

HOUR = 3600.0


class SteppingClock:
    """Wall clock that signals set an hour back or ahead."""

    def __init__(self) -> None:
        self._right_time = time.time
        self._offset = 0.0

    def time(self) -> float:
        """Return the time, as ``time.time`` does [s]."""
        return self._right_time() + self._offset

    def step(self, number: int, _frame: object) -> None:
        """Set the clock, as a signal handler."""
        self._offset += -HOUR if number == signal.SIGUSR1 else HOUR


if __name__ == "__main__":
    clock = SteppingClock()
    time.time = clock.time
    for each in (signal.SIGUSR1, signal.SIGUSR2):
        signal.signal(each, clock.step)
    from nodekit.entry_point import main

    main(sys.argv[1])
