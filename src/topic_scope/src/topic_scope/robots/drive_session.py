"""Drive session of one robot: commands are published immediately, and time out."""

import threading
import time
from typing import Optional

import rospy
from geometry_msgs.msg import Twist, TwistStamped

from topic_scope.robots.dead_man import DeadMan, Velocity

#: Supported types of velocity commands.
TYPES = {"geometry_msgs/Twist": Twist, "geometry_msgs/TwistStamped": TwistStamped}
#: Time for the last message to be sent [s]: queued messages are lost with their publisher.
_LEAVING_S = 0.5


class DriveSession:
    """Publisher of the commands of one robot.

    Uses a separate thread, so that the robot stops in time whatever the scope is doing.

    :param topic: topic of the robot's commands
    :param datatype: their type, one of TYPES
    """

    def __init__(self, topic: str, datatype: str) -> None:
        self.datatype = datatype
        # With a queue, a stalled subscriber does not block others, and gets the newest command.
        self._publisher = rospy.Publisher(topic, TYPES[datatype], queue_size=1)
        self._dead_man = DeadMan()
        self._wake = threading.Condition()
        self._is_closed = False
        threading.Thread(target=self._watch, name="drive", daemon=True).start()

    def drive(self, velocity: Velocity, sent: float) -> bool:
        """Publish a velocity.

        :param velocity: valid for a short time, or until the next command
        :param sent: when the page sent it, by its clock [s]
        :returns: whether it was published; False for a command that arrived too late
        """
        with self._wake:
            if self._is_closed:  # nothing is published after the last zero
                return False
            command = self._dead_man.accept(velocity, sent, time.monotonic())
            self._publish(command)
            self._wake.notify()
        return command is not None

    def close(self) -> bool:
        """Stop the robot if this session has moved it, and unregister the publisher.

        :returns: whether it was moving
        """
        with self._wake:
            zero = self._dead_man.stop()
            self._publish(zero)
            self._is_closed = True
            self._wake.notify()
            return zero is not None

    def _watch(self) -> None:
        with self._wake:
            while not self._is_closed:
                now = time.monotonic()
                self._publish(self._dead_man.expire(now))
                until = self._dead_man.until
                self._wake.wait(None if until is None else until - now)
        time.sleep(_LEAVING_S)
        self._publisher.unregister()

    def _publish(self, velocity: Optional[Velocity]) -> None:
        if velocity is None:
            return
        message = TYPES[self.datatype]()
        twist = getattr(message, "twist", message)
        twist.linear.x, twist.angular.z = velocity
        if twist is not message:
            message.header.stamp = rospy.Time.now()
        try:
            self._publisher.publish(message)
        except rospy.ROSException:  # the scope is shutting down
            pass
