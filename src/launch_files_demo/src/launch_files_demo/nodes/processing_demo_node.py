"""Node that subscribes to three sensors."""

import rospy
from sensor_msgs.msg import Image, LaserScan, Temperature

from nodekit import MultiThreadedExecutor, Node, Throttle, run
from parameters_demo.sensors import of_scan


class ProcessingDemoNode:
    """Logs what it receives from each sensor, at most once a second.

    :ROS Subscribers:
        - ``data/lidar`` (sensor_msgs/LaserScan)
        - ``data/camera`` (sensor_msgs/Image)
        - ``data/temperature`` (sensor_msgs/Temperature)
    """

    def __init__(self, node: Node) -> None:
        self._throttle = Throttle(1.0)
        MultiThreadedExecutor(2).add_node(node)
        node.create_subscription("data/lidar", LaserScan, self.on_lidar)
        node.create_subscription("data/camera", Image, self.on_camera)
        node.create_subscription("data/temperature", Temperature, self.on_temperature)

    def on_lidar(self, scan: LaserScan) -> None:
        """Log the nearest distance."""
        if self._throttle.is_due("lidar"):
            rospy.loginfo("Received LiDAR data: %s", of_scan(scan))

    def on_camera(self, image: Image) -> None:
        """Log the size of the image."""
        if self._throttle.is_due("camera"):
            text = "Received Camera data: width=%d, height=%d"
            rospy.loginfo(text, image.width, image.height)

    def on_temperature(self, temperature: Temperature) -> None:
        """Log the temperature."""
        if self._throttle.is_due("temperature"):
            rospy.loginfo("Received Temperature data: %.2f °C", temperature.temperature)


def main() -> None:
    """Run the node until it is shut down."""
    run("processing_demo_node", ProcessingDemoNode)
