"""Clocks that a thread can wait on: the machine's, or /clock.

``wake`` ends a wait early. rospy's sleep cannot be interrupted, so that a node at 0.1 Hz would
notice a change ten seconds late.
"""

import threading
import time
from typing import Optional

import rospy
from rosgraph_msgs.msg import Clock

#: Longest single wait [s]. Python before 3.11 times its locks by the wall clock,
#: so a wall clock that is set back must not make a wait endless.
_LONGEST_WAIT_S = 1.0
#: Time without simulated time until a warning [s].
_PATIENCE_S = 2.0


class MonotonicClock:
    """Monotonic clock of the machine, independent of the wall clock."""

    def __init__(self) -> None:
        self._wake = threading.Lock()
        self._wake.acquire()

    def now(self) -> Optional[float]:
        """Return the time since a fixed moment [s]."""
        return time.monotonic()

    def wait_until(self, moment: Optional[float]) -> None:
        """Wait for a moment or a :meth:`wake`; may return early.

        :param moment: on the scale of :meth:`now` [s]; None to wait for a wake only
        """
        timeout = _LONGEST_WAIT_S if moment is None else moment - time.monotonic()
        if timeout > _LONGEST_WAIT_S:
            timeout = _LONGEST_WAIT_S
        if timeout > 0.0:
            self._wake.acquire(timeout=timeout)

    def wake(self) -> None:
        """End the current wait, or else the next one immediately."""
        try:
            self._wake.release()
        except RuntimeError:
            pass  # a wake is pending already


class SimulatedClock:
    """Clock of the topic /clock; it may stand still, jump or be set back.

    It warns once if no message arrives at first.
    """

    def __init__(self) -> None:
        self._now: Optional[float] = None
        self._has_warned = False
        self._moved = threading.Event()
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=1)

    def _on_clock(self, message: Clock) -> None:
        self._now = message.clock.to_sec()
        self._moved.set()

    def now(self) -> Optional[float]:
        """Return the simulated time [s]; None before the first message."""
        return self._now

    def wait_until(self, moment: Optional[float]) -> None:
        """Wait for the next step of the clock or a :meth:`wake`.

        :param moment: ignored: the caller checks every step, because the clock may be set back
        """
        is_quiet = self._has_warned or self._now is not None
        if not self._moved.wait(None if is_quiet else _PATIENCE_S):
            self._has_warned = True
            rospy.logwarn("waiting for /clock, as /use_sim_time is set")
            self._moved.wait()
        self._moved.clear()

    def wake(self) -> None:
        """End the current wait, or else the next one immediately."""
        self._moved.set()
