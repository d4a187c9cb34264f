"""Generator, process node and observer as one would write them with rclpy.

Usage: ... generator RECORD RATE, ... process, or ... observer RECORD. The wheels hold std_msgs
only, so the sample is a Float32: less to send than signal_msg. The observer is one of rclpy too, as
DDS cannot be read without a client library.
"""

import contextlib
import math
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float32

from ci.benchmark.record import Record


def generate(node: Node, file: str, rate: str) -> None:
    """Publish a sine."""
    publisher = node.create_publisher(Float32, "signal", 10)
    record, start = Record(file), time.monotonic()

    def publish() -> None:
        message = Float32()
        message.data = 2.0 * math.sin(2.0 * math.pi * (time.monotonic() - start))
        record.add(message.data)
        publisher.publish(message)

    node.create_timer(1.0 / float(rate), publish)


def process(node: Node) -> None:
    """Answer each sample: scaled and lifted."""
    publisher = node.create_publisher(Float32, "proc_signal", 10)

    def answer(message: Float32) -> None:
        output = Float32()
        output.data = 0.5 * message.data + 1.0
        publisher.publish(output)

    node.create_subscription(Float32, "signal", answer, 10)


def observe(node: Node, file: str) -> None:
    """Record each answer."""
    record = Record(file)
    node.create_subscription(Float32, "proc_signal", lambda got: record.add(got.data), 10)


if __name__ == "__main__":
    role, *arguments = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node(role)
    {"generator": generate, "process": process, "observer": observe}[role](node, *arguments)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)
