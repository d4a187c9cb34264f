# Pure: knows no ROS.
"""Rate limit of log lines, one per instance and key; independent of ROS.

rospy's own throttles are keyed by the line of code: two topics or two hosted nodes silence each
other. rospy's "identical" throttles log each time that a number in the text changes.
"""

import time
from typing import Dict, Hashable

#: Above this number of keys, expired keys are removed.
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
        """Return whether to log now; if so, the key is not due again for one period.

        :param key: subject of the line, if the owner logs about several
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
