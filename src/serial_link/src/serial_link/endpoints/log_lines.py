"""Log lines of a board, passed to the ROS log."""

import sys
import time

import rospy
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header

from nodekit import NodeScope
from serial_link.negotiation.payloads import DEBUG, ERROR, FATAL, INFO, WARN

_LEVELS = {
    DEBUG: (Log.DEBUG, "DEBUG"),
    INFO: (Log.INFO, "INFO"),
    WARN: (Log.WARN, "WARN"),
    ERROR: (Log.ERROR, "ERROR"),
    FATAL: (Log.FATAL, "FATAL"),
}
#: Most lines per second.
_PER_SECOND = 20


class LogLines:
    """Log of a board, on rosout under its own node name, and on the console.

    :param scope: creates the publisher
    :param name: of the board
    """

    def __init__(self, scope: NodeScope, name: str) -> None:
        self._publisher = scope.create_publisher("/rosout", Log)
        self._name = name
        self._second = self._lines = 0

    def write(self, level: int, text: str) -> None:
        """Log a line.

        :param level: in the board's numbering
        :param text: the line
        """
        second = int(time.monotonic())
        if second != self._second:
            left_out = self._lines - _PER_SECOND
            self._second, self._lines = second, 0
            if left_out > 0:
                self._put(WARN, f"... and {left_out} more lines in that second")
        self._lines += 1
        if self._lines <= _PER_SECOND:
            self._put(level, text)

    def _put(self, level: int, text: str) -> None:
        number, word = _LEVELS[level]
        stamp = rospy.get_rostime()
        self._publisher.publish(
            Log(header=Header(stamp=stamp), level=number, name=self._name, msg=text)
        )
        if level != DEBUG:
            shown = "".join(letter if letter.isprintable() else " " for letter in text)
            print(f"[{word}] [{stamp.to_sec():.6f}]: {self._name}: {shown}", file=sys.stdout)
            sys.stdout.flush()
