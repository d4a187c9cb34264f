"""Laser scanner of a robot, which produces LaserScan messages."""

import math
from typing import Any

from sensor_msgs.msg import LaserScan

from diff_drive_sim.robot_parameters import RobotParameters
from diff_drive_sim.simulation.kinematics import Pose
from diff_drive_sim.simulation.world import World

#: Shortest range of the laser [m].
RANGE_MIN = 0.01


class Scanner:
    """Laser scanner over 360°: the first ray points ahead, the others follow counter-clockwise.

    :param world: walls and boxes
    :param values: the robot's parameters
    :param frame: name of the laser's frame
    """

    def __init__(self, world: World, values: RobotParameters, frame: str) -> None:
        # Imported late: numpy takes a third of the startup time, and not all robots scan.
        from diff_drive_sim.simulation.laser import Laser

        self._laser = Laser(world.segments, values.scan_rays)
        self._offset = values.laser_x
        self._message = message = LaserScan()
        message.header.frame_id = frame
        message.angle_increment = 2.0 * math.pi / values.scan_rays
        message.angle_max = message.angle_increment * (values.scan_rays - 1)
        message.scan_time = 1.0 / values.scan_rate
        message.range_min, message.range_max = RANGE_MIN, values.scan_range

    def scan(self, pose: Pose, stamp: Any) -> LaserScan:
        """Return a scan; the next call fills the same message again.

        :param pose: of the robot
        :param stamp: ROS time of the scan
        """
        x, y, theta = pose.moved(self._offset, 0.0)
        ranges: Any = self._laser.ranges(x, y, theta)
        # REP 117: infinity means beyond the range, minus infinity too near.
        ranges[ranges > self._message.range_max] = math.inf
        ranges[ranges < RANGE_MIN] = -math.inf
        self._message.header.stamp = stamp
        self._message.ranges = ranges.tolist()
        return self._message
