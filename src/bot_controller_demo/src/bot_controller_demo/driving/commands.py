"""Tell a robot how to move, and to stop at the end."""

import threading
from typing import Any

import rospy
from geometry_msgs.msg import Twist, TwistStamped

from bot_controller_demo.laws.velocities import STOP, Velocity
from nodekit import Node

#: What the velocities are about: the robot's own frame.
_FRAME = "base_footprint"


class Commands:
    """Publishes ``cmd_vel``.

    A stop is said once: silence leaves the topic to others. A robot that was told to move is told
    to stop when the node ends or, where it is managed, is deactivated.

    :param node: makes the publisher
    :param controller_type: rviz for Twist, gazebo for TwistStamped
    """

    def __init__(self, node: Node, controller_type: str) -> None:
        self._is_stamped = controller_type == "gazebo"
        # Made once and filled again: to make one takes longer than all else here.
        self._message: Any = Twist()
        if self._is_stamped:
            self._message = TwistStamped()
            self._message.header.frame_id = _FRAME
        self._publisher = node.publisher("cmd_vel", type(self._message))
        self._last, self._is_closed = STOP, False
        self._lock = threading.RLock()  # who hears it in this process may publish in turn
        node.own(self)
        node.before_deactivate(lambda: self.publish(STOP))
        node.before_end(self.close)

    def publish(self, velocity: Velocity) -> None:
        """Tell the robot how to move.

        :param velocity: what it is to do from now on
        """
        with self._lock:
            self._send(velocity)

    def close(self) -> None:
        """Stop the robot, and say nothing any more."""
        with self._lock:
            self._send(STOP)
            self._is_closed = True

    def _send(self, velocity: Velocity) -> None:
        before, self._last = self._last, velocity
        if not self._is_closed and (velocity != STOP or before != STOP):
            self._publisher.publish(self._filled(velocity))

    def _filled(self, velocity: Velocity) -> Any:
        """Return the message, which tells of a velocity now."""
        message = twist = self._message
        if self._is_stamped:
            message.header.stamp, twist = rospy.Time.now(), message.twist
        twist.linear.x, twist.angular.z = velocity
        return message
