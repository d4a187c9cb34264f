# Pure: knows no ROS.
"""Rate limit of log lines, one per instance and key. Pure: it knows no ROS.

rospy's own throttles are keyed by the line of code: of two topics or two hosted nodes, one silences
the other. rospy's "identical" throttles log each time that a number in the text changes.
"""

import time
from typing import Dict, Hashable

#: With more keys than this, those whose period is over are removed.
_PRUNE_ABOVE = 100


class Throttle:
    """Rate limit of log lines, one per instance and key.

    ``if throttle.is_due("late"): rospy.logwarn(...)``

    :param period: shortest time between two lines of one key [s]
    """

    __slots__ = ("_period", "_quiet_until")

    def __init__(self, period: float) -> None:
        self._period = period
        self._quiet_until: Dict[Hashable, float] = {}

    def is_due(self, key: Hashable = None) -> bool:
        """Return whether to log now; if so, the key is not due again before the period is over.

        :param key: what the line is about, if the owner logs more than one thing
        """
        now = time.monotonic()
        quiet_until = self._quiet_until.get(key)
        if quiet_until is not None and now < quiet_until:
            return False
        if len(self._quiet_until) > _PRUNE_ABOVE:
            keys = list(self._quiet_until.items())
            self._quiet_until = {one: until for one, until in keys if now < until}
        self._quiet_until[key] = now + self._period
        return True
