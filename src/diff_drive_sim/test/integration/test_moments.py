#!/usr/bin/env python3
"""Changes between two odometry messages take effect at their own time."""

import unittest
from typing import Any

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger, TriggerResponse

from diff_drive_sim.nodes.diff_drive import DiffDrive
from nodekit import Names, Node, ParameterClient, init_node
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

ROBOT = "/here/diff_drive"
#: Odometry once a second, and a wall 2 m ahead.
PARAMETERS = {
    "publish_rate": 1.0,
    "scan_rate": 2.0,
    "scan_rays": 4,
    "laser_x": 0.0,
    "command_timeout": 0.0,
    "walls": [[2.0, -1.0, 2.0, 1.0]],
}


class Moments(unittest.TestCase):
    """A robot in this process, which has received its commands."""

    def setUp(self) -> None:
        self.now = 5000.0
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        rospy.set_param(ROBOT, PARAMETERS)
        self.node = Node(Names.hosted("/here", "diff_drive"))
        self.addCleanup(self.node.close)
        DiffDrive(self.node)
        self.node.create_service("~idle", Trigger, lambda _: TriggerResponse(True, ""))
        self.odometry, self.scans = (
            MessageRecorder("/here/odom", Odometry),
            MessageRecorder("/here/scan", LaserScan),
        )
        driver = Node(Names.hosted("/here", "driver"))
        self.addCleanup(driver.close)
        self.commands = driver.create_publisher("cmd_vel", Twist)
        driver.start()
        own_name = rospy.get_name()  # the robots beside this test hear /clock too, perhaps earlier
        Graph().wait_until_heard(own_name, "/clock", own_name)
        self.advance(0.0)
        self.node.start()
        wait_until(lambda: (self.advance(0.01), self.odometry.messages())[1], lambda: "no odometry")
        first = self.odometry.messages()[0].header.stamp.to_sec()
        self.advance(first + 1.0 - self.now)
        self.assertEqual(self.x(), 0.0)

    def advance(self, seconds: float) -> None:
        """Advance the clock, and wait until this process has received it."""
        self.now += seconds
        stamp = rospy.Time.from_sec(self.now)
        self.clock.publish(Clock(stamp))
        wait_until(lambda: rospy.get_rostime() == stamp, lambda: f"{rospy.get_rostime()}")

    def told_now(self, recorder: MessageRecorder) -> Any:
        """Return the message of this moment."""
        return recorder.wait_for(lambda heard: abs(heard.header.stamp.to_sec() - self.now) < 1e-6)

    def x(self) -> float:
        return float(self.told_now(self.odometry).pose.pose.position.x)

    def drive(self, speed: float) -> None:
        message = Twist()
        message.linear.x = speed
        self.commands.publish(message)  # without a connection, as both are in one process
        rospy.ServiceProxy(ROBOT + "/idle", Trigger)()  # its turn comes after the command's

    def test_a_command_acts_from_when_it_arrives(self) -> None:
        self.advance(0.25)  # when neither odometry nor a scan is due
        self.drive(0.2)
        self.advance(0.75)
        self.assertAlmostEqual(self.x(), 0.15)
        self.advance(0.75)
        self.drive(0.1)
        self.advance(0.25)
        self.assertAlmostEqual(self.x(), 0.15 + 0.15 + 0.025)

    def test_a_scan_is_taken_where_the_robot_is_by_then(self) -> None:
        self.drive(0.2)
        self.advance(0.5)
        self.assertAlmostEqual(self.told_now(self.scans).ranges[0], 1.9, places=6)

    def test_a_limit_holds_from_when_it_is_set(self) -> None:
        self.drive(0.2)
        self.advance(0.25)
        ParameterClient(ROBOT).change({"max_linear_velocity": 0.1})
        self.advance(0.75)
        self.assertAlmostEqual(self.x(), 0.05 + 0.075)


if __name__ == "__main__":
    init_node("test_moments")
    rosrun("diff_drive_sim", "moments", Moments)
