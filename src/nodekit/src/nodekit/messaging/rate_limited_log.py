"""Logger with a limit of lines per second, which then logs the number of skipped lines."""

import logging
import sys
import threading
from types import FrameType
from typing import Callable, Optional, Tuple

#: Longest line that is logged in full [characters].
LONGEST = 1000
#: Logged end of a longer line [characters].
_END = 100


def shortened(text: str) -> str:
    """Remove the middle of a very long text.

    :param text: the text
    :returns: a text not much longer than :data:`LONGEST`
    """
    if len(text) <= LONGEST:
        return text
    start = LONGEST - _END
    left_out = len(text) - LONGEST
    return f"{text[:start]}... ({left_out} characters) ...{text[-_END:]}"


#: File, line and function that a line of the log is from.
_Place = Tuple[str, int, str]


def _place_of(frame: FrameType) -> _Place:
    """Return where a frame is, as rospy names it."""
    function, owner = frame.f_code.co_name, frame.f_locals.get("self")
    name = function if owner is None else f"{type(owner).__name__}.{function}"
    return frame.f_code.co_filename, frame.f_lineno, name


def _log_info(text: str, place: _Place) -> None:
    """Log a line as ``rospy.loginfo`` does, but with the place of the line that caused it."""
    logger, (path, line, function) = logging.getLogger("rosout"), place
    if logger.isEnabledFor(logging.INFO):
        fields = (logger.name, logging.INFO, path, line, text, (), None, function)
        logger.handle(logger.makeRecord(*fields))


class RateLimitedLog:
    """Log of a stream of lines; counts the lines above the limit.

    :param per_second: logged lines per second
    :param log: writes one line; by default, as ``rospy.loginfo`` at the line that calls
        :meth:`line`
    """

    #: Allowance for the jitter of a stream at the limit [lines].
    JITTER = 2

    def __init__(self, per_second: int = 10, log: Optional[Callable[[str], None]] = None) -> None:
        self._limit = per_second + self.JITTER
        self._write = log
        self._place: _Place = (__file__, 0, "")
        self._lock = threading.Lock()
        self._count = 0

    def line(self, text: str) -> None:
        """Log a line, or count it if the limit of this second is reached.

        :param text: the line; the middle of a very long one is removed
        """
        with self._lock:
            self._count += 1
            if self._count > self._limit:
                return
        self._place = _place_of(sys._getframe(1))
        self._log(shortened(text))

    def _log(self, text: str) -> None:
        if self._write is None:
            _log_info(text, self._place)
        else:
            self._write(text)

    def end_second(self, _elapsed: float = 0.0) -> None:
        """Log the number of skipped lines of the last second; call this each second."""
        with self._lock:
            left_out, self._count = self._count - self._limit, 0
        if left_out > 0:
            self._log(f"... and {left_out} more in the last second")
