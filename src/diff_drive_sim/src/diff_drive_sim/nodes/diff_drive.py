"""Robot node: drives as commanded, and publishes its pose."""

import math
from typing import Any, Optional, Type

import rospy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import Bool
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from diff_drive_sim.messages.command_topic import any_type_as, decoder
from diff_drive_sim.messages.robot_messages import ODOM, SCAN, RobotMessages
from diff_drive_sim.messages.scanner import Scanner
from diff_drive_sim.messages.world_markers import world_markers
from diff_drive_sim.robot_parameters import GAZEBO, RobotParameters
from diff_drive_sim.simulation.robot import Robot
from nodekit import Node, Throttle, run

#: Shortest time between two warnings about rejected commands [s].
_WARN_EVERY_S = 10.0


class DiffDrive:
    """Robot with two driven wheels.

    A command takes effect when it arrives. Time is ROS time: while /clock does not advance, or is
    set back, the robot does not move; when it jumps ahead, the last command applies at most for its
    timeout.

    :ROS Subscribers:
        - ``cmd_vel`` (geometry_msgs/Twist, or TwistStamped with ``controller_type`` gazebo);
          non-finite commands, and those of the other type, are ignored with a warning

    :ROS Publishers:
        - ``odom`` (nav_msgs/Odometry): estimated pose
        - ``ground_truth`` (nav_msgs/Odometry): true pose, in the same frame
        - ``joint_states`` (sensor_msgs/JointState): wheel_left_joint, wheel_right_joint
        - ``/tf`` (tf2_msgs/TFMessage): odom to base_footprint, and to base_scan
        - ``scan`` (sensor_msgs/LaserScan), with ``scan_rate`` above 0
        - ``contact`` (std_msgs/Bool), latched: whether it touches a wall
        - ``world`` (visualization_msgs/MarkerArray), latched: walls and boxes

    :ROS Services:
        - ``~reset`` (std_srvs/Trigger): put the robot back to its initial pose

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.RobotParameters`
    """

    def __init__(self, node: Node, declaration: Type[RobotParameters] = RobotParameters) -> None:
        self._node = node
        self._parameters = node.declare_parameters(declaration, on_change=self._on_change)
        values = self._parameters.values
        self._robot = Robot(values.robot, values.world, values.initial_pose, values.seed)
        self._messages = RobotMessages(values.frame_prefix, values.laser_x)
        self._scanner: Optional[Scanner] = None
        self._now = rospy.Time()
        self._touched = False
        self._throttle = Throttle(_WARN_EVERY_S)
        self._odom = node.create_publisher("odom", Odometry)
        self._truth = node.create_publisher("ground_truth", Odometry)
        self._joints = node.create_publisher("joint_states", JointState)
        self._tf = node.create_publisher("/tf", TFMessage)
        self._scan = node.create_publisher("scan", LaserScan)
        self._contact = node.create_publisher("contact", Bool, latch=True)
        self._world = node.create_publisher("world", MarkerArray, latch=True)
        self._contact.publish(False)
        self._publish_world(values)
        self._subscribe_commands(values)
        node.create_service("~reset", Trigger, self._reset)
        node.create_timer(lambda: self._parameters.values.publish_rate, self._publish_state)
        node.create_timer(lambda: self._parameters.values.scan_rate, self._publish_scan)

    def _publish_world(self, values: RobotParameters) -> None:
        frame = values.frame_prefix + ODOM
        self._world.publish(world_markers(frame, values.walls, values.boxes))

    def _subscribe_commands(self, values: RobotParameters) -> None:
        """Subscribe to commands of the type set by the parameters."""
        stamped = values.controller_type == GAZEBO
        kind = TwistStamped if stamped else Twist
        self._decode = decoder(kind, "controller_type must be the same in both nodes")
        self._subscription = self._node.create_scope()
        self._subscription.create_subscription("cmd_vel", any_type_as(kind), self._on_command)

    def _on_command(self, raw: Any) -> None:
        message = self._decode(raw)
        if message is None:
            return
        twist: Twist = getattr(message, "twist", message)
        linear, angular = twist.linear.x, twist.angular.z
        if not (math.isfinite(linear) and math.isfinite(angular)):
            text = "%s: ignored a command of %s m/s and %s rad/s: must be finite"
            name = self._node.resolve("cmd_vel")
            if self._throttle.is_due():
                rospy.logwarn(text, name, linear, angular)
            return
        self._catch_up()
        self._robot.command(linear, angular)

    def _catch_up(self) -> None:
        """Move the robot up to the current time."""
        now = rospy.get_rostime()
        self._robot.step(now.secs - self._now.secs + 1e-9 * (now.nsecs - self._now.nsecs))
        self._now = now
        if self._robot.touches != self._touched:
            self._touched = self._robot.touches
            self._contact.publish(self._touched)

    def _publish_state(self, _elapsed: float) -> None:
        self._catch_up()
        messages = self._messages
        messages.fill(self._robot, self._now)
        self._odom.publish(messages.odometry)
        self._truth.publish(messages.truth)
        self._joints.publish(messages.joints)
        values = self._parameters.values
        if values.publish_tf:
            self._tf.publish(messages.transforms(with_laser=values.scan_rate > 0.0))

    def _publish_scan(self, _elapsed: float) -> None:
        self._catch_up()
        values = self._parameters.values
        if self._scanner is None:
            self._scanner = Scanner(self._robot.world, values, values.frame_prefix + SCAN)
        self._scan.publish(self._scanner.scan(self._robot.pose, self._now))

    def _on_change(self, new: RobotParameters, old: RobotParameters) -> None:
        self._catch_up()
        self._robot.change(new.robot)
        self._robot.world = new.world
        self._messages = RobotMessages(new.frame_prefix, new.laser_x)
        self._scanner = None
        self._publish_world(new)
        if new.controller_type != old.controller_type:
            self._subscription.close()
            self._subscribe_commands(new)

    def _reset(self, _request: TriggerRequest) -> TriggerResponse:
        values = self._parameters.values
        self._catch_up()
        self._robot.reset(values.initial_pose, values.seed)
        return TriggerResponse(True, "at x %g m, y %g m, heading %g rad" % values.initial_pose)


def main() -> None:
    """Run the node until it is shut down."""
    run("diff_drive", DiffDrive)
