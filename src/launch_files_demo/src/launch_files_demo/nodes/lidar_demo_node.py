"""Lidar node in a simulated room."""

import math

import rospy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from nodekit import Node, run
from parameters_demo.messages import laser_scan
from parameters_demo.room import Scanner, scan

_RATE_HZ = 10.0
#: Full circle in steps of 1 degree, from 0.2 to 10 m.
SCANNER = Scanner(-math.pi, math.pi, 361, 0.2, 10.0)


class LidarDemoNode:
    """Publishes scans of a room with a walking person, ten times a second.

    :ROS Publishers:
        - ``data/lidar`` (sensor_msgs/LaserScan): in the frame ``laser_frame``
    """

    def __init__(self, node: Node) -> None:
        self._scans = node.create_publisher("data/lidar", LaserScan)
        node.create_timer(_RATE_HZ, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish a scan."""
        header = Header(stamp=rospy.get_rostime(), frame_id="laser_frame")
        ranges = scan(SCANNER, header.stamp.to_sec())
        self._scans.publish(laser_scan(header, SCANNER, ranges, 1.0 / _RATE_HZ))


def main() -> None:
    """Run the node until it is shut down."""
    run("lidar_demo_node", LidarDemoNode)
