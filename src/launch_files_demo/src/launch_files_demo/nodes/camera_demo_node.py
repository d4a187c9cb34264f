"""Camera node with a test card."""

import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from nodekit import Node, run
from parameters_demo.messages import image
from parameters_demo.picture import Picture

_RATE_HZ = 1.0


class CameraDemoNode:
    """Publishes a test card with a moving object, once a second.

    :ROS Publishers:
        - ``data/camera`` (sensor_msgs/Image): 640 by 480, rgb8, in the frame ``camera_frame``
    """

    def __init__(self, node: Node) -> None:
        self._picture = Picture(node.name.rpartition("/")[2])
        self._frames = 0
        self._images = node.create_publisher("data/camera", Image)
        node.create_timer(_RATE_HZ, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish the next frame."""
        header = Header(stamp=rospy.get_rostime(), frame_id="camera_frame")
        data = self._picture.draw(self._frames, header.stamp.to_sec())
        self._images.publish(image(header, data))
        self._frames += 1


def main() -> None:
    """Run the node until it is shut down."""
    run("camera_demo_node", CameraDemoNode)
