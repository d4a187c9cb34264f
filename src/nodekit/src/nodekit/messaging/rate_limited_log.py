"""Log a stream of messages without drowning in it."""

import threading
from typing import Callable

import rospy

#: Longest line that is logged in full, characters.
LONGEST = 1000
#: Of a longer one, what is logged of its end, characters.
_END = 100


def shortened(text: str) -> str:
    """Leave out the middle of a very long text.

    :param text: the text
    :returns: a text not much longer than :data:`LONGEST`
    """
    if len(text) <= LONGEST:
        return text
    start = LONGEST - _END
    left_out = len(text) - LONGEST
    return f"{text[:start]}... ({left_out} characters) ...{text[-_END:]}"


class RateLimitedLog:
    """Logs each line of a slow stream, and of a quick one how much was left out.

    :param per_second: how many lines a second are logged, 1/s
    :param log: writes one line; ``rospy.loginfo`` by default
    """

    #: A stream at just the limit may, by jitter, put more into one second.
    JITTER = 2

    def __init__(self, per_second: int = 10, log: Callable[[str], None] = rospy.loginfo) -> None:
        self._limit = per_second + self.JITTER
        self._log = log
        self._lock = threading.Lock()
        self._count = 0

    def line(self, text: str) -> None:
        """Log a line, or count it where there were too many this second.

        :param text: the line; its middle is left out where it is very long
        """
        with self._lock:
            self._count += 1
            if self._count > self._limit:
                return
        self._log(shortened(text))

    def end_second(self, _elapsed: float = 0.0) -> None:
        """Tell what was left out in the second that ends now; to be called each second."""
        with self._lock:
            left_out, self._count = self._count - self._limit, 0
        if left_out > 0:
            self._log(f"... and {left_out} more in the last second")
