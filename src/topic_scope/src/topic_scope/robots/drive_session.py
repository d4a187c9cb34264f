"""Drive session of one robot: commands are published at once, and time out."""

import threading
import time
from typing import Optional

import rospy
from geometry_msgs.msg import Twist, TwistStamped

from topic_scope.robots.dead_man import DeadMan, Velocity

#: The types of commands that a robot may take.
TYPES = {"geometry_msgs/Twist": Twist, "geometry_msgs/TwistStamped": TwistStamped}
#: How long the last message may take to leave [s]: what waits is lost with its publisher.
_LEAVING_S = 0.5


class DriveSession:
    """Publishes commands for one robot.

    It has a thread of its own, so that the robot stops in time whatever else the scope is doing.

    :param topic: where the robot takes commands
    :param datatype: what it takes, one of TYPES
    """

    def __init__(self, topic: str, datatype: str) -> None:
        self.datatype = datatype
        # With a queue, a subscriber that does not read blocks no other, and gets the newest one.
        self._publisher = rospy.Publisher(topic, TYPES[datatype], queue_size=1)
        self._dead_man = DeadMan()
        self._wake = threading.Condition()
        self._is_closed = False
        threading.Thread(target=self._watch, name="drive", daemon=True).start()

    def drive(self, velocity: Velocity, sent: float) -> bool:
        """Publish a velocity.

        :param velocity: for a short time, or until the next one
        :param sent: when the page has sent it, by its clock [s]
        :returns: whether it was told; False for a command that came too late
        """
        with self._wake:
            if self._is_closed:  # nothing comes after the last zero
                return False
            told = self._dead_man.accept(velocity, sent, time.monotonic())
            self._publish(told)
            self._wake.notify()
        return told is not None

    def close(self) -> bool:
        """Stop the robot if this session has moved it, and unregister the publisher.

        :returns: whether it was
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
        except rospy.ROSException:  # the scope has ended
            pass
