#!/usr/bin/env python3
"""A robot that was brought up sees, and is sent somewhere."""

import os
import unittest

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log

from bot_controller_demo_msgs.srv import SetGoal
from nodekit.testing.changing import change
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scripts/robot_control.py")


class Bringup(unittest.TestCase):
    def test_robot_is_sent_and_the_script_ends_when_it_is_there(self) -> None:
        """Course 002-pkg-16."""
        odometry = MessageRecorder("/odom", Odometry)
        script = Process(SCRIPT, ["_x:=0.3", "_y:=0"])
        self.addCleanup(script.end)
        self.assertEqual(script.wait(), 0)
        self.assertTrue(script.logged("the robot goes to x 0.3 m, y 0 m, theta 0 rad"))
        wait_until(odometry.count, lambda: "no odometry")
        self.assertAlmostEqual(odometry.messages()[-1].pose.pose.position.x, 0.25, delta=0.06)

    def test_the_script_ends_with_a_status_where_the_robot_does_not_get_there(self) -> None:
        self.addCleanup(change, "/base", walls=Graph().parameter("/base/walls"))
        self.addCleanup(change, "/proportional_controller", no_progress_timeout=10.0)
        change("/base", walls=[[-1.0, 1.0, 2.0, 1.0]])
        change("/proportional_controller", no_progress_timeout=1.0)
        script = Process(SCRIPT, ["_x:=0", "_y:=1.5"])
        self.addCleanup(script.end)
        self.assertEqual(script.wait(), 1)
        self.assertTrue(script.logged("the robot makes no progress: ", " m are left"), script.lines)

    def test_the_script_ends_with_a_status_where_somebody_sends_the_robot_elsewhere(self) -> None:
        script = Process(SCRIPT, ["_x:=-3", "_y:=0"])
        self.addCleanup(script.end)
        script.wait_for_log("the robot goes to x -3 m")
        set_goal = rospy.ServiceProxy("/proportional_controller/set_goal", SetGoal)
        self.assertTrue(set_goal(0.0, 0.0, 0.0).success)
        self.assertEqual(script.wait(), 1)
        self.assertTrue(script.logged("the robot was sent elsewhere: to x 0 m, y 0 m"))

    def test_what_it_sees_is_processed_as_it_is_configured(self) -> None:
        """Course 002-pkg-14."""
        log = MessageRecorder("/rosout", Log)
        seen = log.wait_for(lambda line: "brightness" in line.msg and "nearest" in line.msg)
        self.assertEqual(seen.name, "/processing_demo")
        for line in ("frame from: head_camera", "scan from: chest_lidar (OS2)"):
            log.wait_for(lambda heard: heard.msg == f"Published {line}")


if __name__ == "__main__":
    rospy.init_node("test_bringup")
    rosrun("humanoid_robot_bringup", "bringup", Bringup)
