"""Messages that a robot publishes.

They are reused for each publication, because a hundred robots publish them thirty times a second.
"""

import math
from typing import Any

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from diff_drive_sim.simulation.kinematics import Pose
from diff_drive_sim.simulation.odometry import EXACT, Covariance
from diff_drive_sim.simulation.robot import Robot

#: As turtlebot3_fake names them.
ODOM, BASE, SCAN = "odom", "base_footprint", "base_scan"
LEFT_JOINT, RIGHT_JOINT = "wheel_left_joint", "wheel_right_joint"
#: Variances: of exact values, nonzero for filters that divide by it; and of unmeasured values.
EXACT_VARIANCE, UNKNOWN_VARIANCE = 1e-9, 1e6
#: Indices of x, y and the heading in a 6 x 6 covariance.
_PLACES = (0, 1, 5, 7, 11, 35)
_MIRRORED = ((1, 6), (5, 30), (11, 31))
_VARIANCES = (0, 7, 35)
#: Height of the laser, for display only [m].
_LASER_Z = 0.18


class RobotMessages:
    """All messages of one robot.

    :param prefix: of the names of its frames
    :param laser_x: distance of its laser ahead of the axle [m]
    """

    def __init__(self, prefix: str, laser_x: float) -> None:
        self.odometry = _odometry(prefix)
        self.truth = _odometry(prefix)
        self.joints = JointState()
        self.joints.header.frame_id = prefix + BASE
        self.joints.name = [LEFT_JOINT, RIGHT_JOINT]
        self.joints.effort = [0.0, 0.0]
        self.base = _transform(prefix + ODOM, prefix + BASE)
        self.laser = _transform(prefix + BASE, prefix + SCAN)
        self.laser.transform.translation.x = laser_x
        self.laser.transform.translation.z = _LASER_Z
        self.laser.transform.rotation.w = 1.0

    def transforms(self, with_laser: bool) -> TFMessage:
        """Return the transforms of the robot in its odometry frame, and of its laser."""
        return TFMessage([self.base, self.laser] if with_laser else [self.base])

    def fill(self, robot: Robot, stamp: Any) -> None:
        """Fill all messages except the scan.

        :param robot: its state
        :param stamp: time of the state, as ROS time
        """
        speeds = robot.speeds
        _fill(self.odometry, robot.odometry.pose, speeds, robot.odometry.covariance, stamp)
        _fill(self.truth, robot.pose, speeds, EXACT, stamp)
        self.joints.header.stamp = stamp
        self.joints.position = robot.odometry.angles
        self.joints.velocity = robot.wheels
        pose = self.odometry.pose.pose
        self.base.header.stamp = self.laser.header.stamp = stamp
        self.base.transform.translation.x = pose.position.x
        self.base.transform.translation.y = pose.position.y
        self.base.transform.rotation = pose.orientation


def _odometry(prefix: str) -> OdometryMessage:
    message = OdometryMessage()
    message.header.frame_id = prefix + ODOM
    message.child_frame_id = prefix + BASE
    for covariance in (message.pose.covariance, message.twist.covariance):
        covariance[:] = [0.0] * 36
        for place in range(0, 36, 7):
            covariance[place] = EXACT_VARIANCE if place in _VARIANCES else UNKNOWN_VARIANCE
    return message


def _transform(parent: str, child: str) -> TransformStamped:
    message = TransformStamped()
    message.header.frame_id = parent
    message.child_frame_id = child
    return message


def _fill(
    message: OdometryMessage, pose: Pose, speeds: Any, covariance: Covariance, stamp: Any
) -> None:
    message.header.stamp = stamp
    where = message.pose.pose
    where.position.x, where.position.y = pose.x, pose.y
    where.orientation.z, where.orientation.w = math.sin(pose.theta / 2), math.cos(pose.theta / 2)
    message.twist.twist.linear.x, message.twist.twist.angular.z = speeds
    rows = message.pose.covariance
    for place, value in zip(_PLACES, covariance):
        rows[place] = value
    for place in _VARIANCES:
        rows[place] = max(rows[place], EXACT_VARIANCE)
    for place, mirrored in _MIRRORED:
        rows[mirrored] = rows[place]
