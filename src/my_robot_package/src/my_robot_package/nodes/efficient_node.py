"""Image processing without a backlog and without copies."""

import time

import numpy
from sensor_msgs.msg import Image
from std_msgs.msg import Float32

from nodekit import FloatParameter, Node, ParameterSet, SingleThreadedExecutor, run


class EfficientNodeParameters(ParameterSet):
    """Parameters of efficient_node."""

    processing_time = FloatParameter(
        0.0, minimum=0.0, maximum=3600.0, unit="s", help="additional time to process an image"
    )


class EfficientNode:
    """Publishes the brightness of images; while it is busy, only the newest image is kept.

    - The queue holds one image, so the handled image is never old.
    - The image is not copied: a camera node in this process shares its memory.
    - The output message is created once and reused.

    :ROS Subscribers:
        - ``image_topic`` (sensor_msgs/Image)

    :ROS Publishers:
        - ``mean_brightness`` (std_msgs/Float32): mean of all bytes, from 0 to 255; nothing for an
          empty image

    :ROS Parameters:
        - private, can be changed at run time: see :class:`EfficientNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(EfficientNodeParameters)
        SingleThreadedExecutor().add_node(node)
        self._answer = Float32()
        self._publisher = node.create_publisher("mean_brightness", Float32)
        # nodekit requests tcp_nodelay from every publisher.
        node.create_subscription(
            "image_topic", Image, self.image_callback, queue_size=1, views=True
        )

    def image_callback(self, image: Image) -> None:
        """Publish the brightness of an image."""
        if image.data:
            self._answer.data = numpy.frombuffer(image.data, numpy.uint8).mean()
            time.sleep(self._parameters.values.processing_time)
            self._publisher.publish(self._answer)


def main() -> None:
    """Run the node until it is shut down."""
    run("efficient_node", EfficientNode)
