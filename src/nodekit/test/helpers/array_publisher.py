#!/usr/bin/env python3
"""Publish numbered arrays of 1 MB at 100 Hz, from the number in the first argument on."""

import os
import sys
import threading
import time

from helpers.array_subscriber import numbered
from std_msgs.msg import UInt8MultiArray

from nodekit import run


class ArrayPublisher:
    """Node with one publisher."""

    def __init__(self, node) -> None:
        self._publisher = node.create_publisher("topic", UInt8MultiArray, queue_size=10)
        threading.Thread(target=self._publish_all, daemon=True).start()

    def _publish_all(self) -> None:
        number = int(sys.argv[1])
        while True:
            self._publisher.publish(UInt8MultiArray(data=numbered(number, 1_000_000)))
            number += 1
            time.sleep(0.01)


if __name__ == "__main__":
    run(f"array_publisher_{os.getpid()}", ArrayPublisher)
