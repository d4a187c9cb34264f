"""Pauses of the machine itself: a loop that only sleeps, beside what is measured.

On a busy machine every process waits for its turn. The figures of this loop show what part of a
silence is the machine's.
"""

import signal
import time

from ..benchmark.peer_programs import module
from ..benchmark.processes import Session
from .streams import Arrivals

PERIOD = 1e-3


class Control:
    """The loop, in a process of its own.

    :param session: runs it
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._process = session.start(module("endurance.control"))

    def stop(self) -> str:
        """End the loop, and return its pauses in words."""
        self._session.stop(self._process)
        return self._session.log_of(self._process).strip()


def main() -> None:
    """Sleep, a millisecond at a time, until Ctrl-C; then print the pauses."""
    ended = []
    signal.signal(signal.SIGINT, lambda *_: ended.append(True))
    arrivals = Arrivals()
    while not ended:
        arrivals.add(time.monotonic())
        time.sleep(PERIOD)
    print(arrivals)


if __name__ == "__main__":
    main()
