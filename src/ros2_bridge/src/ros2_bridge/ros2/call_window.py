"""Limit of pending calls to a ROS 2 service, whose server drops requests beyond its queue size."""

import threading
import time
from typing import Dict, Optional

#: Default queue size of a server in rclpy and rclcpp. Beyond it, the oldest request is dropped
#: silently.
QUEUE = 10
#: Age from which a call counts as taken from the queue [s]: the server handles several in parallel,
#: or is too slow anyway.
_TAKEN_S = 1.0


class CallWindow:
    """Limit of pending calls to the queue size of a server; thread-safe.

    :param most: most calls younger than ``taken``
    :param taken: age from which a call is not counted [s]
    """

    def __init__(self, most: int = QUEUE, taken: float = _TAKEN_S) -> None:
        self._most, self._taken = most, taken
        self._changed = threading.Condition()
        self._began: Dict[int, float] = {}
        self._next = 0

    def enter(self, deadline: float) -> Optional[int]:
        """Wait until a call may be sent.

        :param deadline: end of the wait, on the monotonic clock [s]
        :returns: number for :meth:`leave`; None if the deadline passed
        """
        with self._changed:
            while True:
                now = time.monotonic()
                young = [began for began in self._began.values() if now < began + self._taken]
                if len(young) < self._most:
                    self._next += 1
                    self._began[self._next] = now
                    return self._next
                if now >= deadline:
                    return None
                self._changed.wait(min(deadline, min(young) + self._taken) - now)

    def leave(self, number: int) -> None:
        """Stop counting a call: it was answered or abandoned."""
        with self._changed:
            del self._began[number]
            self._changed.notify()

    def __len__(self) -> int:
        """Return the number of pending calls of any age."""
        with self._changed:
            return len(self._began)
