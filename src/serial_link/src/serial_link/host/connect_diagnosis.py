"""Diagnosis of a board that does not answer, from the bytes before its first good frame."""

from serial_link.framing.frames import count_old_frames

#: Most bytes kept.
MOST_KEPT = 4096
#: This many frames of the old protocol cannot be a coincidence.
_ENOUGH = 2
#: Usual baud rates, including those of AVRs at 16 MHz and of an ESP8266's bootloader [Bd].
_USUAL_BAUD = [
    *(2400, 4800, 9600, 14400, 19200, 28800, 38400, 57600, 74880, 76800, 115200, 230400),
    *(
        250000,
        256000,
        460800,
        500000,
        576000,
        921600,
        1000000,
        1152000,
        1500000,
        2000000,
        2500000,
        3000000,
        3500000,
    ),
    4000000,
]
#: Largest relative difference of a mistyped rate from the usual one, such as 56700 from 57600.
_MISTYPED = 0.05


class ConnectDiagnosis:
    """Diagnosis from the bytes since the port was opened, up to the first good frame.

    :ivar is_over: whether a good frame has been received
    """

    def __init__(self) -> None:
        self._unread = bytearray()
        self.is_over = False

    def add(self, data: bytes, has_frames: bool) -> None:
        """Keep received bytes.

        :param data: the bytes
        :param has_frames: whether a good frame has been received
        """
        if has_frames:
            self.is_over = True
            self._unread.clear()
        if not self.is_over:
            self._unread += data
            del self._unread[:-MOST_KEPT]

    def clear(self) -> None:
        """Reset, after the port was opened."""
        self._unread.clear()
        self.is_over = False

    def explain(self, baud: int) -> str:
        """Return why a board may not answer, and what to check.

        :param baud: bits per second of the line; 0 without a line
        """
        if count_old_frames(self._unread) >= _ENOUGH:
            return (
                "the board uses rosserial's protocol from before ROS Hydro (version byte 0xff; "
                "this node needs 0xfe): build its sketch with a newer library"
            )
        if self._unread:
            what = _describe(baud) if baud else "rosserial"
            return (
                f"the received bytes are not rosserial messages: does the sketch use {what}, and "
                "does nothing else write to its port?"
            )
        place = f"at {_describe(baud)}" if baud else "for this port"
        return (
            "the board sends nothing: does its sketch call initNode, and spinOnce in its loop, "
            f"{place}?"
        )


def _describe(baud: int) -> str:
    """Return the baud rate in words; if it may be a mistyped usual one, with that one."""
    usual = min(_USUAL_BAUD, key=lambda one: abs(one - baud))
    is_near = 0 < abs(usual - baud) < _MISTYPED * baud
    return f"{baud} baud" + (f" ({usual} is usual)" if is_near else "")
