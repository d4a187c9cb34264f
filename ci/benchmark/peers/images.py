#!/usr/bin/env python3
"""A camera, its subscriber, or both, by nodekit or rospy, recording each message's number.

Usage: images.py publish|subscribe|both nodekit|views|rospy KIND BYTES SUBSCRIBERS RECORD…
KIND is image, points, or bytes: an array without size and encoding, as in the rclpy peer.
"""

import functools
import os
import sys
import threading
import time
from typing import Any, Callable

import rospy
from sensor_msgs.msg import Image, PointCloud2, PointField
from std_msgs.msg import UInt8MultiArray

from ci.benchmark.record import Record
from nodekit import Node, run

ROLE, STACK, KIND, BYTES, SUBSCRIBERS, *FILES = sys.argv[1:]
RATE = 30.0  # Hz
#: Size of a point, as of most laser scanners [bytes].
POINT = 16
CLASS: Any = {"image": Image, "points": PointCloud2, "bytes": UInt8MultiArray}[KIND]


def new_message(data: bytes, number: int) -> Any:
    """Return a message with data and a number."""
    if CLASS is UInt8MultiArray:
        message = UInt8MultiArray(data=data)
        message.layout.data_offset = number
        return message
    if CLASS is Image:
        return Image(height=1, width=number, step=len(data), encoding="rgb8", data=data)
    names = ("x", "y", "z", "intensity")
    fields = [PointField(name, 4 * n, PointField.FLOAT32, 1) for n, name in enumerate(names)]
    return PointCloud2(
        height=1, width=number, fields=fields, point_step=POINT, row_step=len(data), data=data
    )


def number_of(message: Any) -> int:
    """Return the number of a message."""
    return int(message.layout.data_offset if CLASS is UInt8MultiArray else message.width)


def publish_all(publish: Callable[[Any], None], connected: Callable[[], int]) -> None:
    """Publish at :data:`RATE` once all subscribers are connected, until the process ends."""
    record, data, number = Record(FILES[-1]), os.urandom(int(BYTES)), 0
    while connected() < (1 if ROLE == "both" else int(SUBSCRIBERS)):
        time.sleep(0.05)
    due = time.monotonic()
    while not rospy.is_shutdown():
        message = new_message(data, number)
        record.add(number)
        publish(message)
        number += 1
        due = max(due + 1.0 / RATE, time.monotonic())
        time.sleep(due - time.monotonic() if due > time.monotonic() else 0.0)


class Camera:
    """Publisher by nodekit."""

    def __init__(self, node: Node) -> None:
        publisher = node.create_publisher("images", CLASS, queue_size=10)
        arguments = (publisher.publish, publisher.get_num_connections)
        threading.Thread(target=publish_all, args=arguments, daemon=True).start()


class Viewer:
    """Subscriber by nodekit."""

    def __init__(self, node: Node) -> None:
        for file in FILES[:-1] or FILES:
            receive = functools.partial(self._receive, Record(file))
            node.create_subscription("images", CLASS, receive, views=STACK == "views")

    @staticmethod
    def _receive(record: Record, message: Any) -> None:
        record.add(number_of(message))


class Both:
    """Publisher and subscribers in one node."""

    def __init__(self, node: Node) -> None:
        Viewer(node)
        Camera(node)


def main() -> None:
    """Run until the process is ended."""
    name = f"{ROLE}_{os.getpid()}"
    if STACK != "rospy":
        run(name, {"publish": Camera, "subscribe": Viewer, "both": Both}[ROLE])
    rospy.init_node(name)
    if ROLE == "publish":
        publisher = rospy.Publisher("images", CLASS, queue_size=10)
        publish_all(publisher.publish, publisher.get_num_connections)
    else:
        record = Record(FILES[0])
        rospy.Subscriber("images", CLASS, lambda message: record.add(number_of(message)))
        rospy.spin()


if __name__ == "__main__":
    main()
