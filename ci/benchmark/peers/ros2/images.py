"""A camera or its subscriber as one would write them with rclpy, recording each message's number.

Usage: ... publish|subscribe BYTES SUBSCRIBERS RECORD. The wheels hold std_msgs only, so a picture
is an array without size and encoding.
"""

import array
import contextlib
import os
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray

from ci.benchmark.record import Record

RATE = 30.0  # Hz


def publish(node: Node, size: int, subscribers: int, file: str) -> None:
    """Publish at :data:`RATE` once all subscribers are connected, until the process ends."""
    publisher = node.create_publisher(UInt8MultiArray, "images", 10)
    record, message = Record(file), UInt8MultiArray()
    message.data = array.array("B", os.urandom(size))
    while publisher.get_subscription_count() < subscribers:
        time.sleep(0.05)

    def send() -> None:
        record.add(message.layout.data_offset)
        publisher.publish(message)
        message.layout.data_offset += 1

    node.create_timer(1.0 / RATE, send)


def subscribe(node: Node, file: str) -> None:
    """Record each message."""
    record = Record(file)
    node.create_subscription(
        UInt8MultiArray, "images", lambda got: record.add(got.layout.data_offset), 10
    )


if __name__ == "__main__":
    role, size, subscribers, file = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node(f"{role}_{os.getpid()}", namespace=os.environ["ROS_NAMESPACE"])
    if role == "publish":
        publish(node, int(size), int(subscribers), file)
    else:
        subscribe(node, file)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)
