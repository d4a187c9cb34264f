"""Absolute deadlines on an even grid, so that periodic work does not drift."""

import math
from typing import Optional

#: A deadline less than this ahead counts as passed, s: stamps of /clock are
#: rounded, since 1970 to 2.4e-7 s, and must not miss the deadlines they meet.
SLACK_S = 1e-6

#: Lowest rate to offer, Hz. Long before the smallest numbers there are, a period is infinite.
SLOWEST_HZ = 1e-6


class Timetable:
    """When a periodic task is due, and what time has passed for it.

    Deadlines are ``anchor + n / rate``. The anchor moves only when the rate
    changes or the clock is set back, so that rounding and lateness never add
    up. Elapsed time counts on over both.

    :param rate: how often the task is due, Hz; above 0 and below 1 / SLACK_S
    :param catch_up: lateness up to which every deadline is taken, one after the
        other, s; of those that are later only the latest is
    """

    def __init__(self, rate: float, catch_up: float = 0.0) -> None:
        self._rate = rate
        self._catch_up = catch_up
        self._anchor: Optional[float] = None
        self._elapsed_at_anchor = 0.0
        #: Number of the next deadline, counted from 0 at the anchor, and that deadline.
        self._next = 0
        self._deadline = 0.0
        self._taken_at = float("-inf")

    def deadline(self, now: float) -> float:
        """Return when the task is due next; at once, where it was never taken.

        :param now: the time, s
        :returns: a moment on the same scale, s
        """
        if self._anchor is None:
            self._anchor = self._deadline = now
        return self._deadline

    def take(self, now: float) -> float:
        """Take a deadline that has passed: the next, or the latest if that is too late.

        :param now: the time, at or after the deadline, s
        :returns: time from the first deadline to this one, s
        """
        anchor = self._anchor
        if anchor is None:
            anchor = self._anchor = self._deadline = now
        self._next += 1
        if now - self._deadline > self._catch_up:
            self._next = max(self._next, self._first_after(now, anchor))
        self._deadline = anchor + self._next / self._rate
        self._taken_at = now
        return self._elapsed_at_anchor + (self._next - 1) / self._rate

    def set_rate(self, rate: float) -> None:
        """Change the rate; the next deadline counts from the last one taken.

        :param rate: how often the task is due from now on, Hz
        """
        if self._anchor is not None and self._next:
            last = (self._next - 1) / self._rate
            self._anchor += last
            self._elapsed_at_anchor += last
            self._rate = rate
            self._next = self._first_after(self._taken_at, self._anchor)
            self._deadline = self._anchor + self._next / rate
        self._rate = rate

    def restart(self, now: float) -> None:
        """Go on from a clock that was set back: due at once, one period on.

        :param now: the time that the clock was set to, s
        """
        self._elapsed_at_anchor += self._next / self._rate
        self._anchor = self._deadline = now
        self._next = 0

    def _first_after(self, now: float, anchor: float) -> int:
        """Return the number of the first deadline that has not passed yet."""
        number = max(1, math.floor((now + SLACK_S - anchor) * self._rate))
        while anchor + number / self._rate <= now + SLACK_S:
            number += 1  # at most twice: rounding may hide that a deadline is met
        return number
