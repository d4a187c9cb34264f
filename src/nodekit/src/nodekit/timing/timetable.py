# Pure: knows no ROS.
"""Absolute deadlines on an even grid, so that periodic work does not drift."""

import math
from typing import Optional

#: A deadline less than this ahead counts as passed [s]: stamps of /clock are
#: rounded, since 1970 to 2.4e-7 s, and must not miss the deadlines they meet.
SLACK_S = 1e-6


class Timetable:
    """Deadlines of a periodic task, and the time that has passed for it.

    Deadlines are ``anchor + n / rate``. The anchor moves only when the rate
    changes or the clock is set back, so that rounding and lateness never add
    up. The elapsed time continues in both cases.

    :param rate: rate of the task [Hz]; 0 or above, and below 1 / SLACK_S; 0 pauses
    :param catch_up: lateness up to which every deadline is taken, one after the
        other [s]; of later ones only the latest is taken
    """

    __slots__ = (
        "skipped",
        "next_deadline",
        "_rate",
        "_is_paused",
        "_catch_up",
        "_is_retimed",
        "_anchor",
        "_elapsed_at_anchor",
        "_next",
        "_taken_at",
    )

    def __init__(self, rate: float, catch_up: float = 0.0) -> None:
        #: Skipped deadlines, which were too late.
        self.skipped = 0
        self._rate = rate
        self._is_paused = rate == 0.0
        self._catch_up = catch_up
        #: Whether the rate was changed since a deadline was taken last.
        self._is_retimed = False
        #: Minus infinity before it began.
        self._anchor = -math.inf
        self._elapsed_at_anchor = 0.0
        #: Number of the next deadline, counted from 0 at the anchor, and that deadline [s].
        self._next = 0
        self.next_deadline = self._taken_at = -math.inf

    @property
    def deadline(self) -> Optional[float]:
        """Next deadline [s]; minus infinity before the first, None during a pause."""
        return None if self._is_paused else self.next_deadline

    def begin(self, now: float) -> None:
        """Set the first deadline, unless it is set already.

        :param now: that deadline [s]
        """
        if self._anchor == -math.inf:
            self._anchor = self.next_deadline = now

    def take_deadline(self, now: float) -> float:
        """Take a deadline that has passed: the next, or the latest if that is too late.

        :param now: the time, at or after the deadline [s]
        :returns: time from the first deadline to this one [s]
        """
        if self._anchor == -math.inf:
            self.begin(now)
        following = self._next + 1
        # Deadlines of a new rate may lie in the past.
        catch_up = 0.0 if self._is_retimed else self._catch_up
        if now - self.next_deadline > catch_up:
            latest = max(following, self._first_after(now, self._anchor))
            if not self._is_retimed:
                self.skipped += latest - following
            following = latest
        self._is_retimed = False
        self._next = following
        self.next_deadline = self._anchor + following / self._rate
        self._taken_at = now
        return self._elapsed_at_anchor + (following - 1) / self._rate

    def set_rate(self, rate: float) -> None:
        """Change the rate; the next deadline counts from the last one taken.

        :param rate: new rate [Hz]; 0 pauses
        """
        if rate == (0.0 if self._is_paused else self._rate):
            return
        self._is_paused = rate == 0.0
        if self._is_paused:
            return
        if self._next:
            self._is_retimed = True
            last = (self._next - 1) / self._rate
            self._anchor += last
            self._elapsed_at_anchor += last
            self._rate = rate
            self._next = self._first_after(self._taken_at, self._anchor)
            self.next_deadline = self._anchor + self._next / rate
        self._rate = rate

    def restart(self, now: float) -> None:
        """Continue after the clock was set back: due now, and one period later.

        :param now: the new time of the clock [s]
        """
        if self._next:
            self._elapsed_at_anchor += self._next / self._rate
        self._anchor = self.next_deadline = now
        self._next = 0

    def _first_after(self, now: float, anchor: float) -> int:
        """Return the number of the first deadline that has not passed yet."""
        number = max(1, math.floor((now + SLACK_S - anchor) * self._rate))
        while anchor + number / self._rate <= now + SLACK_S:
            number += 1  # at most twice: rounding may hide that a deadline is met
        return number
