"""Diagnosis of a board that does not answer, from the bytes before its first good frame."""

from serial_link.framing.frames import count_old_frames

#: How much is kept [bytes].
MOST_KEPT = 4096
#: So many frames of the old protocol are no accident.
_ENOUGH = 2


class ConnectDiagnosis:
    """Diagnosis from the bytes since the port was opened, up to the first good frame."""

    def __init__(self) -> None:
        self._unread = bytearray()
        self._is_understood = False

    def add(self, data: bytes, has_frames: bool) -> None:
        """Keep what has arrived.

        :param data: the bytes
        :param has_frames: whether there is a good frame by now
        """
        if has_frames:
            self._is_understood = True
            self._unread.clear()
        if not self._is_understood:
            self._unread += data
            del self._unread[:-MOST_KEPT]

    def clear(self) -> None:
        """Reset, as the port was opened."""
        self._unread.clear()
        self._is_understood = False

    def explain(self, baud: int) -> str:
        """Return a sentence that says why a board may not answer, and what to look at.

        :param baud: bits a second of the line; 0 without a line
        """
        if count_old_frames(self._unread) >= _ENOUGH:
            return (
                "the board speaks rosserial's protocol of before ROS Hydro (version byte 0xff; "
                "0xfe is spoken here): build its sketch with a newer library"
            )
        if self._unread:
            what = f"{baud} baud" if baud else "rosserial"
            return (
                f"what arrives is no message of rosserial: does the sketch use {what} too, and "
                "nothing else write to its port?"
            )
        place = f"at {baud} baud" if baud else "for this port"
        return (
            "the board says nothing: does its sketch call initNode and, again and again, spinOnce, "
            f"{place}?"
        )
