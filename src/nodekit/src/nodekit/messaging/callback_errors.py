"""Log what a user's function raises: not each time, and without ending what called it."""

import traceback

import rospy
import rospy.core

from nodekit.throttle import Throttle

#: A function's failures are logged at most this often, s.
LOG_PERIOD_S = 5.0


class CallbackErrors(Throttle):
    """The failures of one function.

    :ivar count: how many there were
    """

    __slots__ = ("count",)

    def __init__(self) -> None:
        super().__init__(LOG_PERIOD_S)
        self.count = 0

    def record(self, what: str, is_ending: bool = False) -> None:
        """Count the exception that is being handled, and log it with its traceback now and then.

        :param what: names the function
        :param is_ending: whether the function was closed while it was under way
        """
        self.count += 1
        # What fails when the end has begun fails because of it, as a call of a closed client.
        is_ending = is_ending or rospy.core.is_shutdown_requested()
        if not is_ending and self.is_due():
            text = "%s failed, %d times so far:\n%s"
            rospy.logerr(text, what, self.count, traceback.format_exc().rstrip())
