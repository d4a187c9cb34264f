#!/usr/bin/env python3
"""Run a node with a wall clock that jumps an hour back on SIGUSR1, an hour ahead on SIGUSR2.

The machine's clock is unchanged: only Python code of the node reads the wrong time. The first
argument is the name of the node's module, e.g. ``basic_comms.nodes.talker``.
"""

import signal
import sys
import time

HOUR = 3600.0

_right_time = time.time
_offset = 0.0


def set_wall_clock(number: int, _frame: object) -> None:
    """Handle a signal."""
    global _offset
    _offset += -HOUR if number == signal.SIGUSR1 else HOUR


if __name__ == "__main__":
    time.time = lambda: _right_time() + _offset
    for each in (signal.SIGUSR1, signal.SIGUSR2):
        signal.signal(each, set_wall_clock)
    from nodekit.entry_point import main

    main(sys.argv[1])
