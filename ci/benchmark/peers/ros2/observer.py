"""Observer of the answers: DDS cannot be read without a client library.

Usage: ... RECORD
"""

import contextlib
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float32

from ci.benchmark.record import Record


def main() -> None:
    """Record until interrupted."""
    rclpy.init()
    node = rclpy.create_node("observer")
    record = Record(sys.argv[1])
    node.create_subscription(Float32, "proc_signal", lambda got: record.add(got.data), 10)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
