# Pure: knows no ROS.
"""Log the same thing now and then only, each for itself. Pure: it knows no ROS.

rospy's own throttles know lines of code: of two topics, one keeps the other quiet; and what counts
as identical there is logged each time that a number in it changes.
"""

import time


class Throttle:
    """Tells when something may be said again.

    :param period: shortest time from one line to the next, s
    """

    __slots__ = ("_period", "_quiet_until")

    def __init__(self, period: float) -> None:
        self._period = period
        self._quiet_until = 0.0

    def is_due(self) -> bool:
        """Tell whether it may be said now; then it is not due again before the period is over."""
        now = time.monotonic()
        is_due = now >= self._quiet_until
        if is_due:
            self._quiet_until = now + self._period
        return is_due
