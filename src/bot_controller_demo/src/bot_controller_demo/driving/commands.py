"""Publisher of commands to a robot, which stops it at the end."""

import threading
from typing import Any

import rospy
from geometry_msgs.msg import Twist, TwistStamped

from bot_controller_demo.control.velocities import STOP, Velocity
from nodekit import Node

#: Velocities are in the robot's frame.
_FRAME = "base_footprint"


class Commands:
    """Publisher of ``cmd_vel``.

    A stop is published once, so that others may use the topic afterwards. A moving robot is stopped
    when the node ends or, if it is managed, is deactivated.

    :param node: creates the publisher
    :param controller_type: rviz for Twist, gazebo for TwistStamped
    """

    def __init__(self, node: Node, controller_type: str) -> None:
        self._is_stamped = controller_type == "gazebo"
        # Reused, because creating a message takes longer than all else here.
        self._message: Any = Twist()
        if self._is_stamped:
            self._message = TwistStamped()
            self._message.header.frame_id = _FRAME
        self._publisher = node.create_publisher("cmd_vel", type(self._message))
        self._last = STOP
        self._is_closed = False
        self._lock = threading.RLock()  # a subscriber in this process may publish in turn
        node.own(self)
        node.before_deactivate(lambda: self.publish(STOP))
        node.on_shutdown(self.close)

    def publish(self, velocity: Velocity) -> None:
        """Command the robot.

        :param velocity: new velocity
        """
        with self._lock:
            self._send(velocity)

    def close(self) -> None:
        """Stop the robot, and stop publishing."""
        with self._lock:
            self._send(STOP)
            self._is_closed = True

    def _send(self, velocity: Velocity) -> None:
        before, self._last = self._last, velocity
        if not self._is_closed and (velocity != STOP or before != STOP):
            self._publisher.publish(self._filled(velocity))

    def _filled(self, velocity: Velocity) -> Any:
        """Return the message, filled with a velocity and the current time."""
        message = twist = self._message
        if self._is_stamped:
            message.header.stamp, twist = rospy.Time.now(), message.twist
        twist.linear.x, twist.angular.z = velocity
        return message
