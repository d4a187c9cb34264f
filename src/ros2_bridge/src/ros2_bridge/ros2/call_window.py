"""Window of the calls that a server of ROS 2 may still have in its queue."""

import threading
import time
from typing import Dict, Optional

#: Requests that a server keeps: rclpy's and rclcpp's default. Of more, it drops the oldest in
#: silence.
QUEUE = 10
#: Age from which a call counts as taken from the queue [s]: the server works on several at once, or
#: is too slow for all of them anyhow.
_TAKEN_S = 1.0


class CallWindow:
    """Admits as many calls at a time as a server's queue holds, for any number of threads.

    :param most: most calls that are younger than ``taken``
    :param taken: age from which a call is not counted [s]
    """

    def __init__(self, most: int = QUEUE, taken: float = _TAKEN_S) -> None:
        self._most, self._taken = most, taken
        self._changed = threading.Condition()
        self._began: Dict[int, float] = {}
        self._next = 0

    def enter(self, deadline: float) -> Optional[int]:
        """Wait until a call may be sent.

        :param deadline: end of the wait [s], on the monotonic clock
        :returns: number for :meth:`leave`; None if it may not be sent in time
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
        """Count a call no longer: it was answered or given up."""
        with self._changed:
            del self._began[number]
            self._changed.notify()

    def __len__(self) -> int:
        """Return the number of calls under way, whatever their age."""
        with self._changed:
            return len(self._began)
