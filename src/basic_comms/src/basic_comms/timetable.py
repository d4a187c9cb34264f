"""Absolute deadlines on an even grid, so that periodic work does not drift."""

import math
from typing import Optional


class Timetable:
    """When a periodic task is due, and what time has passed for it.

    Deadlines are ``anchor + n / rate``. The anchor moves only when the rate
    changes or the clock is set back, so that rounding and lateness never add
    up. Elapsed time counts on over both.

    :param rate: how often the task is due, Hz; above 0
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._anchor: Optional[float] = None
        self._elapsed_at_anchor = 0.0
        self._taken = 0

    def deadline(self, now: float) -> float:
        """Return when the task is due next; at once, where it was never taken.

        :param now: the time, s
        :returns: a moment on the same scale, s
        """
        if self._anchor is None:
            self._anchor = now
        return self._anchor + self._taken / self._rate

    def take(self, now: float) -> float:
        """Take the latest deadline that has passed; earlier ones are skipped.

        :param now: the time, at or after the deadline, s
        :returns: time from the first deadline to this one, s
        """
        start = self.deadline(now) if self._anchor is None else self._anchor
        latest = max(self._taken, math.floor((now - start) * self._rate))
        self._taken = latest + 1
        return self._elapsed_at_anchor + latest / self._rate

    def set_rate(self, rate: float, now: float) -> None:
        """Change the rate; the next deadline counts from the last one taken.

        :param rate: how often the task is due from now on, Hz; above 0
        :param now: the time, s
        """
        if self._anchor is not None and self._taken:
            last = (self._taken - 1) / self._rate
            due = max(self._anchor + last + 1.0 / rate, now)
            self._elapsed_at_anchor += due - self._anchor
            self._anchor = due
            self._taken = 0
        self._rate = rate

    def restart(self, now: float) -> None:
        """Go on from a clock that was set back: due at once, one period on.

        :param now: the time that the clock was set to, s
        """
        self._elapsed_at_anchor += self._taken / self._rate
        self._anchor = now
        self._taken = 0
