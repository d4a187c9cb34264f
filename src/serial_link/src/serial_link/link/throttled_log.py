"""Throttled log, one limit per key."""

import math
import threading
import time
from typing import Callable, Dict


class ThrottledLog:
    """Throttled log with one limit per key.

    rospy's throttles are per line of code: of two topics, one would keep the other quiet.

    :param period: least time between two lines about one thing [s]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._lock = threading.Lock()
        self._said_at: Dict[str, float] = {}

    def log(self, log: Callable[[str], None], text: str, about: str = "") -> None:
        """Log a text, unless its key was logged within the period.

        :param log: logs it
        :param text: the sentence
        :param about: what it is about; the sentence itself by default
        """
        now = time.monotonic()
        with self._lock:
            if now - self._said_at.get(about or text, -math.inf) < self._period:
                return
            self._said_at[about or text] = now
        log(text)

    def reset(self) -> None:
        """Reset all limits."""
        with self._lock:
            self._said_at.clear()
