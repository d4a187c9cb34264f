"""Pacing of frames to the baud rate, and frames that take too long at it."""

from serial_link.framing.frames import OVERHEAD

#: Bits per byte on the line: start bit, eight data bits, stop bit.
BITS = 10
#: The next frame is written this long before the line is free [s], so that a late thread leaves no
#: gap. A written frame cannot be replaced by a newer value.
AHEAD_S = 0.002
#: rosserial's library drops a frame that is incomplete after this time [ms].
LONGEST_FRAME_MS = 20


def explain_drop(size: int, baud: int) -> str:
    """Return why rosserial's library drops a frame that is written in one piece, or an empty text.

    Such a frame is sent nevertheless: a board with a larger receive buffer than an AVR's may find
    all of it there.

    :param size: of the payload [bytes]
    :param baud: bits per second; 0 without a serial line
    """
    if (size + OVERHEAD) * BITS * 1000 <= LONGEST_FRAME_MS * baud or not baud:
        return ""
    return (
        f"{size} bytes take longer than the {LONGEST_FRAME_MS} ms after which rosserial's library "
        f"drops a message ({baud} baud)"
    )


class BaudPacer:
    """Pacer that keeps the system's transmit buffer nearly empty.

    The system buffers 4 KB, which take 0.7 s at 57 600 baud; new values would queue behind them.
    Time is an argument [s].

    :param baud: bits per second; 0 for no pacing
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
        :param count: number of bytes
        """
        self._free_at = max(now, self._free_at) + count * self._seconds
