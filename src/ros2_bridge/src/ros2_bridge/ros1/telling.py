"""Says what is not bridged, each reason once and at most one line a second."""

import contextlib
import threading
import time
from typing import Iterator, List, Set

import rospy

#: Least time between two lines, s.
_PAUSE_S = 1.0
#: Most reasons in one line; the others come in the next.
_MOST = 5


class Telling:
    """Collects sentences, which :meth:`look` logs."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._said: Set[str] = set()
        self._waiting: List[str] = []
        self._last = -_PAUSE_S

    def say(self, sentence: str) -> None:
        """Have something said, unless it was said before."""
        with self._lock:
            if sentence not in self._said:
                self._said.add(sentence)
                self._waiting.append(sentence)

    @contextlib.contextmanager
    def guarding(self, name: str) -> Iterator[None]:
        """Say why something cannot be bridged, whatever it is: all else must be.

        :param name: of a topic, service or node
        """
        try:
            yield
        except Exception as error:
            # Of rclpy's texts some draw below where in the name it is.
            why = (str(error) or repr(error)).partition("\n")[0].rstrip(":")
            self.say(f"{name}: {why}")

    def look(self) -> None:
        """Log what is waiting, if it is time."""
        now = time.monotonic()
        with self._lock:
            if not self._waiting or now < self._last + _PAUSE_S:
                return
            part, self._waiting = self._waiting[:_MOST], self._waiting[_MOST:]
            self._last = now
        rospy.logwarn("not bridged: %s", "; ".join(part))
