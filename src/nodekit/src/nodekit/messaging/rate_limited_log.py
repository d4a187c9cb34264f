"""Log of a stream of lines, with a limit of lines per second."""

import threading
from typing import Callable

import rospy

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


class RateLimitedLog:
    """Log of a stream of lines; counts the lines above the limit.

    :param per_second: logged lines per second
    :param log: writes one line; ``rospy.loginfo`` by default
    """

    #: Allowance for the jitter of a stream at the limit [lines].
    JITTER = 2

    def __init__(self, per_second: int = 10, log: Callable[[str], None] = rospy.loginfo) -> None:
        self._limit = per_second + self.JITTER
        self._log = log
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
        self._log(shortened(text))

    def end_second(self, _elapsed: float = 0.0) -> None:
        """Log the number of skipped lines of the last second; call this each second."""
        with self._lock:
            left_out, self._count = self._count - self._limit, 0
        if left_out > 0:
            self._log(f"... and {left_out} more in the last second")
