"""Lidar node in a simulated room, with a choice of models."""

import rospy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from nodekit import EnumParameter, IntParameter, Node, ParameterSet, StringParameter, Throttle, run
from parameters_demo.messages import laser_scan
from parameters_demo.room import MODELS, scan


class LidarDemoParameters(ParameterSet):
    """Parameters of lidar_demo."""

    lidar_name = StringParameter("lidar", help="Name of the lidar")
    lidar_rate = IntParameter(
        20, minimum=20, maximum=100, step=20, unit="Hz", help="Lidar scan rate in Hz"
    )
    lidar_model = EnumParameter("OS2", choices=tuple(MODELS), help="Model of the lidar")


class LidarDemo:
    """Publishes scans of a room with a walking person.

    The model determines the range, the field of view and the resolution.

    :ROS Publishers:
        - ``lidar/points`` (sensor_msgs/LaserScan): in the frame ``NAME_frame``

    :ROS Parameters:
        - private, can be changed at run time: see :class:`LidarDemoParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(LidarDemoParameters)
        self._throttle = Throttle(1.0)
        self._scans = node.create_publisher("lidar/points", LaserScan)
        node.create_timer(lambda: self._parameters.values.lidar_rate, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish a scan."""
        settings = self._parameters.values
        now = rospy.get_rostime()
        header = Header(stamp=now, frame_id=f"{settings.lidar_name}_frame")
        scanner = MODELS[settings.lidar_model]
        ranges = scan(scanner, now.to_sec())
        self._scans.publish(laser_scan(header, scanner, ranges, 1.0 / settings.lidar_rate))
        if self._throttle.is_due():
            text = "Published scan from: %s (%s)"
            rospy.loginfo(text, settings.lidar_name, settings.lidar_model)


def main() -> None:
    """Run the node until it is shut down."""
    run("lidar_demo", LidarDemo)
