"""Log what a user's function raises: not each time, and without ending what called it."""

import time
import traceback

import rospy
import rospy.core

#: A function's failures are logged at most this often, s.
LOG_PERIOD_S = 5.0


class Failures:
    """The failures of one function.

    :ivar count: how many there were
    """

    __slots__ = ("count", "_quiet_until")

    def __init__(self) -> None:
        self.count = 0
        self._quiet_until = 0.0

    def note(self, what: str, is_ending: bool = False) -> None:
        """Count the exception that is being handled, and log it with its traceback now and then.

        :param what: names the function
        :param is_ending: whether the function was closed while it was under way
        """
        self.count += 1
        now = time.monotonic()
        # What fails when the end has begun fails because of it, as a call of a closed client.
        is_ending = is_ending or rospy.core.is_shutdown_requested()
        if now >= self._quiet_until and not is_ending:
            self._quiet_until = now + LOG_PERIOD_S
            text = "%s failed, %d times by now:\n%s"
            rospy.logerr(text, what, self.count, traceback.format_exc().rstrip())
