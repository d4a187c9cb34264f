"""Pacing of frames by the baud rate."""

#: Bits on the line for a byte: one to start, eight, one to stop.
BITS = 10
#: So much earlier than the line is free the next frame is written [s]: a thread that wakes up late
#: leaves no gap. What is written cannot be replaced by a newer value any more.
AHEAD_S = 0.002


class BaudPacer:
    """Pacer of frames, so that as few as possible wait in the system's buffer.

    The system takes 4 KB at once, which at 57 600 baud are 0.7 s: the newest value would come after
    all of them. Time is an argument [s].

    :param baud: bits a second; 0 for a line that is not paced
    """

    def __init__(self, baud: int) -> None:
        self._seconds = BITS / baud if baud else 0.0
        self._free_at = 0.0

    def delay(self, now: float) -> float:
        """Return how long to wait before the next frame is written [s].

        :param now: the time [s]
        """
        return max(0.0, self._free_at - AHEAD_S - now)

    def record_write(self, now: float, count: int) -> None:
        """Record a write.

        :param now: the time [s]
        :param count: bytes
        """
        self._free_at = max(now, self._free_at) + count * self._seconds
