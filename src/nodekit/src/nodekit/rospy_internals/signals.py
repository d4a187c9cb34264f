"""How rospy hears signals of the operating system."""

import signal
from types import FrameType
from typing import Any, Optional

import rospy.core


def register() -> None:
    """Have rospy shut the node down on SIGINT and SIGTERM, and when its terminal is closed.

    ``rospy.init_node`` does the same for the first two where it is called by the main thread. But
    rospy's answer to a second signal interrupts its answer to the first, and does what must not
    be done twice at a time, such as writing to the log file: the node hung, or ended with a
    traceback. Here only the first is answered.
    """
    rospy.core.register_signals()
    shut_down: Any = signal.getsignal(signal.SIGTERM)
    numbers = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # which is nohup's doing
        numbers.append(signal.SIGHUP)

    def answer_first(number: int, frame: Optional[FrameType]) -> None:
        for each in numbers:
            signal.signal(each, _leave)
        shut_down(number, frame)

    for number in numbers:
        signal.signal(number, answer_first)


def _leave(_number: int, _frame: Optional[FrameType]) -> None:
    """Do nothing. SIG_IGN in its place makes Python complain of a signal that is on its way."""
