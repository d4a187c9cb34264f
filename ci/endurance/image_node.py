#!/usr/bin/env python3
"""Camera, or a viewer that checks its pictures.

Usage: image_node.py camera RATE BYTES, or image_node.py viewer copy|view SUMMARY. A viewer writes
its summary when it ends.
"""

import json
import pathlib
import sys

from nodekit import Node, run
from sensor_msgs.msg import Image

ROLE, *ARGUMENTS = sys.argv[1:4]
#: Length of the number at both ends of a picture [bytes].
NUMBER = 8


class Camera:
    """Publishes numbered pictures."""

    def __init__(self, node: Node) -> None:
        rate, size = map(int, ARGUMENTS)
        self._number, self._data = 0, bytearray(size)
        # A second's pictures: a viewer on a busy machine may pause.
        self._publisher = node.create_publisher("images", Image, queue_size=rate)
        node.create_timer(rate, self._publish)

    def _publish(self, _time: float) -> None:
        if self._publisher.get_num_connections():
            number = self._number.to_bytes(NUMBER, "big")
            self._data[:NUMBER] = self._data[-NUMBER:] = number
            self._publisher.publish(Image(width=self._number, data=self._data))
            self._number += 1


class Viewer:
    """Checks numbers."""

    def __init__(self, node: Node) -> None:
        kind, self._file = ARGUMENTS
        self._received = self._missing = self._torn = 0
        self._next = -1
        node.create_subscription("images", Image, self._check, views=kind == "view")
        node.on_shutdown(self._write)

    def _check(self, image: Image) -> None:
        number = image.width.to_bytes(NUMBER, "big")
        self._torn += image.data[:NUMBER] != number or image.data[-NUMBER:] != number
        if self._received:
            self._missing += image.width - self._next
        self._next = image.width + 1
        self._received += 1

    def _write(self) -> None:
        summary = {"received": self._received, "missing": self._missing, "torn": self._torn}
        pathlib.Path(self._file).write_text(json.dumps(summary))


if __name__ == "__main__":
    run(ROLE, Camera if ROLE == "camera" else Viewer)
