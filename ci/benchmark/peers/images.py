#!/usr/bin/env python3
"""A camera, its subscriber, or both, by nodekit or rospy, recording each message's number.

Usage: images.py publish|subscribe|both nodekit|views|rospy image|points BYTES SUBSCRIBERS RECORD…
"""

import functools
import os
import sys
import threading
import time
from typing import Any, Callable

import rospy
from sensor_msgs.msg import Image, PointCloud2, PointField

from ci.benchmark.record import Record
from nodekit import Node, run

ROLE, STACK, KIND, BYTES, SUBSCRIBERS, *FILES = sys.argv[1:]
RATE = 30.0  # Hz
#: Size of a point, as of most laser scanners [bytes].
POINT = 16
CLASS: Any = Image if KIND == "image" else PointCloud2


def new_message(data: bytes) -> Any:
    """Return a message with its data."""
    if CLASS is Image:
        return Image(height=1, step=len(data), encoding="rgb8", data=data)
    names = ("x", "y", "z", "intensity")
    fields = [PointField(name, 4 * n, PointField.FLOAT32, 1) for n, name in enumerate(names)]
    return PointCloud2(height=1, fields=fields, point_step=POINT, row_step=len(data), data=data)


def publish_all(publish: Callable[[Any], None], connected: Callable[[], int]) -> None:
    """Publish at :data:`RATE` once all subscribers are connected, until the process ends."""
    record, data, number = Record(FILES[-1]), os.urandom(int(BYTES)), 0
    while connected() < (1 if ROLE == "both" else int(SUBSCRIBERS)):
        time.sleep(0.05)
    due = time.monotonic()
    while not rospy.is_shutdown():
        message = new_message(data)
        message.width = number
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
        record.add(message.width)


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
        rospy.Subscriber("images", CLASS, lambda message: record.add(message.width))
        rospy.spin()


if __name__ == "__main__":
    main()
