"""Warning about a node's constructor that waits, as for a message that cannot arrive yet."""

import contextlib
import os
import sys
import threading
import time
from types import FrameType
from typing import Iterator, Optional

import rospy

#: Longest time that a constructor may wait without a warning [s].
PATIENCE_S = 5.0
#: A constructor that computes for more than this part of the time is not waiting.
_BUSY = 0.5
#: Folders with code that waits on behalf of its caller: Python's library, rospy, nodekit.
_LIBRARIES = tuple(
    os.path.dirname(os.path.abspath(path)) + os.sep
    for path in (threading.__file__, rospy.__file__, os.path.dirname(__file__))
)


class ConstructorWatch:
    """Watch over a constructor that another thread runs."""

    def __init__(self) -> None:
        self._thread = self._clock = 0
        self._since: Optional[float] = None

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Watch what the calling thread does in this block."""
        self._thread = threading.get_ident()
        self._clock = time.pthread_getcpuclockid(self._thread)
        self._busy_before = time.clock_gettime(self._clock)
        self._since = time.monotonic()
        try:
            yield
        finally:
            self._since = None

    def warn_if_waiting(self) -> None:
        """Warn once, with the user's line, if the constructor waits for too long."""
        since = self._since
        if since is None or time.monotonic() - since < PATIENCE_S:
            return
        frame = sys._current_frames().get(self._thread)
        try:
            busy = time.clock_gettime(self._clock) - self._busy_before
        except OSError:  # the thread has just ended
            return
        if self._since is None or busy > _BUSY * PATIENCE_S:
            return
        self._since = None
        rospy.logwarn(
            "the constructor has waited for %g s at %s; messages, ticks and calls begin only once "
            "it has returned: wait for them in a callback",
            PATIENCE_S,
            _user_line(frame),
        )


def _user_line(frame: Optional[FrameType]) -> str:
    """Return file and line of the innermost frame outside of libraries."""
    while frame is not None:
        if not frame.f_code.co_filename.startswith(_LIBRARIES):
            return f"{frame.f_code.co_filename}:{frame.f_lineno}"
        frame = frame.f_back
    return "an unknown line"
