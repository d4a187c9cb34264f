"""Log of the exceptions of user callbacks, rate-limited."""

import traceback

import rospy
import rospy.core

from nodekit.throttle import Throttle

#: Shortest time between two log lines about exceptions of one function [s].
LOG_PERIOD_S = 5.0


class CallbackErrors(Throttle):
    """Exceptions of one function.

    :ivar count: number of exceptions
    """

    __slots__ = ("count",)

    def __init__(self) -> None:
        super().__init__(LOG_PERIOD_S)
        self.count = 0

    def record(self, what: str, is_ending: bool = False) -> None:
        """Count the current exception, and log it with its traceback, rate-limited.

        :param what: name of the function
        :param is_ending: whether the function was closed during its call
        """
        self.count += 1
        # An exception during shutdown is a consequence of it, as of a call of a closed client.
        is_ending = is_ending or rospy.core.is_shutdown_requested()
        if not is_ending and self.is_due():
            text = "%s failed, %d times so far:\n%s"
            rospy.logerr(text, what, self.count, traceback.format_exc().rstrip())
