"""A node that subscribes to three sensors."""

import rospy
from sensor_msgs.msg import Image, LaserScan, Temperature

from nodekit import MultiThreadedExecutor, Node, run
from parameters_demo.sensors import of_scan


class ProcessingDemoNode:
    """Logs what it receives from each sensor, at most once a second.

    :ROS Subscribers:
        - ``data/lidar`` (sensor_msgs/LaserScan)
        - ``data/camera`` (sensor_msgs/Image)
        - ``data/temperature`` (sensor_msgs/Temperature)
    """

    def __init__(self, node: Node) -> None:
        MultiThreadedExecutor(2).add_node(node)
        node.create_subscription("data/lidar", LaserScan, self.on_lidar)
        node.create_subscription("data/camera", Image, self.on_camera)
        node.create_subscription("data/temperature", Temperature, self.on_temperature)

    def on_lidar(self, scan: LaserScan) -> None:
        """Log what is nearest."""
        rospy.loginfo_throttle(1.0, f"Received LiDAR data: {of_scan(scan)}")

    def on_camera(self, image: Image) -> None:
        """Log how large the image is."""
        text = f"Received Camera data: width={image.width}, height={image.height}"
        rospy.loginfo_throttle(1.0, text)

    def on_temperature(self, temperature: Temperature) -> None:
        """Log how warm it is."""
        text = f"Received Temperature data: {temperature.temperature:.2f} °C"
        rospy.loginfo_throttle(1.0, text)


def main() -> None:
    """Run the node until it is shut down."""
    run("processing_demo_node", ProcessingDemoNode)
