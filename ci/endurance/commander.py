#!/usr/bin/env python3
"""Numbered commands at 10 Hz, each number with a check value."""

from nodekit import Node, run
from std_msgs.msg import UInt32

RATE = 10.0
#: Factor of a number for its check value: an odd one, far from a power of 2.
CHECK = 40503


class Commander:
    """Publishes on ``command``."""

    def __init__(self, node: Node) -> None:
        self._number = 0
        self._publisher = node.create_publisher("command", UInt32, queue_size=1)
        node.create_timer(RATE, self._publish)

    def _publish(self, _time: float) -> None:
        self._number = self._number % 0xFFFF + 1
        self._publisher.publish(UInt32(self._number << 16 | self._number * CHECK & 0xFFFF))


if __name__ == "__main__":
    run("commander", Commander)
