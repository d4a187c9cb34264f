"""Robot that follows its commands and stores them."""

import math
import threading
import time
from typing import Any, List, NamedTuple, Optional

import rospy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

#: Period of its odometry [s].
_PERIOD_S = 0.05


class Command(NamedTuple):
    """Received command.

    :param when: s on the monotonic clock
    :param speed: m/s
    :param turn: rad/s
    """

    when: float
    speed: float
    turn: float


class Robot:
    """Robot that subscribes to ``cmd_vel`` and ``goal``, and publishes ``odom`` and ``scan``.

    :param space: the namespace, with a slash at its end
    :param kind: type of its commands
    """

    def __init__(self, space: str, kind: Any = Twist) -> None:
        self.commands: List[Command] = []
        self.goals: List[PoseStamped] = []
        self.x = self.y = self.heading = 0.0
        self.odometry = rospy.Publisher(space + "odom", Odometry, queue_size=1)
        self.scan = rospy.Publisher(space + "scan", LaserScan, queue_size=1)
        self._subscribers = [
            rospy.Subscriber(space + "cmd_vel", kind, self._on_command, tcp_nodelay=True),
            rospy.Subscriber(space + "goal", PoseStamped, self.goals.append),
        ]
        self._told: Optional[Command] = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _on_command(self, message: Any) -> None:
        twist = getattr(message, "twist", message)
        self._told = Command(time.monotonic(), twist.linear.x, twist.angular.z)
        self.commands.append(self._told)

    def _run(self) -> None:
        scan = LaserScan(range_min=0.1, range_max=9.0, angle_increment=math.pi / 8)
        scan.header.frame_id, scan.ranges = "base", [2.0] * 16
        message = Odometry(child_frame_id="base")
        message.header.frame_id = "odom"
        while not self._ended.wait(_PERIOD_S):
            reply = self._told
            if reply is not None:
                self.heading += reply.turn * _PERIOD_S
                self.x += reply.speed * math.cos(self.heading) * _PERIOD_S
                self.y += reply.speed * math.sin(self.heading) * _PERIOD_S
            pose = message.pose.pose
            pose.position.x, pose.position.y = self.x, self.y
            pose.orientation.z = math.sin(self.heading / 2)
            pose.orientation.w = math.cos(self.heading / 2)
            self.odometry.publish(message)
            self.scan.publish(scan)

    def close(self) -> None:
        """Leave the graph."""
        self._ended.set()
        self._thread.join()
        for end in (*self._subscribers, self.odometry, self.scan):
            end.unregister()
