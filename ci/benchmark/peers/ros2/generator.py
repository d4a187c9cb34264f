"""The signal generator as one would write it with rclpy. Usage: ... RECORD RATE

The wheels hold std_msgs only, so the sample is a Float32: less to send than signal_msg.
"""

import contextlib
import math
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float32

from ci.benchmark.record import Record


def main() -> None:
    """Publish until interrupted."""
    rclpy.init()
    node = rclpy.create_node("signal_generator")
    publisher = node.create_publisher(Float32, "signal", 10)
    record = Record(sys.argv[1])
    start = time.monotonic()

    def publish() -> None:
        message = Float32()
        message.data = 2.0 * math.sin(2.0 * math.pi * (time.monotonic() - start))
        record.add(message.data)
        publisher.publish(message)

    node.create_timer(1.0 / float(sys.argv[2]), publish)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
