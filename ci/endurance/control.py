"""How long the machine itself pauses: a loop that only sleeps, beside what is measured.

Where the machine is busy, every process waits for its turn. The figures of this loop tell what of
a silence is the machine's part.
"""

import signal
import subprocess
import time

from ..benchmark.peer_programs import module
from ..benchmark.processes import Session
from .streams import GAP, Arrivals

PERIOD = 1e-3


class Control:
    """The loop, in a process of its own.

    :param session: where it runs
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._process: "subprocess.Popen[bytes]" = session.start(module("endurance.control"))

    def stop(self) -> str:
        """End the loop.

        :returns: how long its pauses were
        """
        self._session.stop(self._process)
        return self._session.log_of(self._process).strip()


def silences(arrivals: Arrivals) -> str:
    """Tell how long a stream was silent, and how often for long."""
    text = "%.1f ms at most, %d above %g ms"
    return text % (1e3 * arrivals.longest_gap, arrivals.gaps, 1e3 * GAP)


def main() -> None:
    """Sleep, a millisecond at a time, until Ctrl-C; then tell of the pauses."""
    ended = []
    signal.signal(signal.SIGINT, lambda *_: ended.append(True))
    arrivals = Arrivals()
    while not ended:
        arrivals.add(time.monotonic())
        time.sleep(PERIOD)
    print(silences(arrivals))


if __name__ == "__main__":
    main()
