"""A robot's laser: what it sees of the world, as a message."""

import math
from typing import Any

from sensor_msgs.msg import LaserScan

from diff_drive_sim.robot_parameters import RobotParameters
from diff_drive_sim.simulation.kinematics import Pose
from diff_drive_sim.simulation.world import World

#: How near the laser sees, m.
RANGE_MIN = 0.01


class Scanner:
    """Scans all around: the first ray goes ahead, the others follow counter-clockwise.

    :param world: what it sees
    :param values: the robot's parameters
    :param frame: name of the laser's frame
    """

    def __init__(self, world: World, values: RobotParameters, frame: str) -> None:
        # Only now: a robot that never scans does without numpy, which takes a third of its start.
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
        """Return what the laser sees; the next call fills the same message again.

        :param pose: where the robot is
        :param stamp: when, a time of ROS
        """
        x, y, theta = pose.moved(self._offset, 0.0)
        ranges: Any = self._laser.ranges(x, y, theta)
        # REP 117: infinity is beyond the range, minus infinity too near.
        ranges[ranges > self._message.range_max] = math.inf
        ranges[ranges < RANGE_MIN] = -math.inf
        self._message.header.stamp = stamp
        self._message.ranges = ranges.tolist()
        return self._message
