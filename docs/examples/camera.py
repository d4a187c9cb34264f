#!/usr/bin/env python3
"""Publishes pictures of 1920 x 1080 pixels at 30 Hz."""

import numpy
from sensor_msgs.msg import Image

from nodekit import Node, run


class Camera:
    """A grey picture that becomes brighter."""

    def __init__(self, node: Node) -> None:
        self._picture = numpy.zeros((1080, 1920, 3), numpy.uint8)
        self._publisher = node.create_publisher("image_topic", Image, queue_size=10)
        node.create_timer(30.0, self._publish)

    def _publish(self, time: float) -> None:
        self._picture[:] = int(10.0 * time) % 256
        image = Image(height=1080, width=1920, encoding="rgb8", step=3 * 1920)
        image.data = self._picture.tobytes()
        self._publisher.publish(image)


if __name__ == "__main__":
    run("camera", Camera)
