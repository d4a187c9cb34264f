"""Temperature sensor node."""

import random

import rospy
from sensor_msgs.msg import Temperature
from std_msgs.msg import Header

from launch_files_demo.temperature import VARIANCE, measured
from nodekit import Node, run

_RATE_HZ = 1.0


class TemperatureDemoNode:
    """Publishes a noisy temperature that varies once a minute between -5 and 35 degrees.

    :ROS Publishers:
        - ``data/temperature`` (sensor_msgs/Temperature): once a second
    """

    def __init__(self, node: Node) -> None:
        self._chance = random.Random()
        self._temperatures = node.create_publisher("data/temperature", Temperature)
        node.create_timer(_RATE_HZ, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish a measurement."""
        header = Header(stamp=rospy.get_rostime(), frame_id="temperature_frame")
        value = measured(header.stamp.to_sec(), self._chance)
        self._temperatures.publish(Temperature(header, value, VARIANCE))


def main() -> None:
    """Run the node until it is shut down."""
    run("temperature_demo_node", TemperatureDemoNode)
