#!/usr/bin/env python3
"""The demos log the same lines as the course's, in the same order."""

import os
import unittest
from typing import List

import rospy

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nodekit.testing.processes import Process, Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")


def said(process: Process) -> List[str]:
    """Return the texts of the log's lines, in their order."""
    return [line.partition("]: ")[2] for line in process.lines if "[INFO]" in line]


class Demos(unittest.TestCase):
    """Each demo in a separate process."""

    def start(self, name: str, *arguments: str) -> Process:
        process = Process(os.path.join(SCRIPTS, name), arguments)
        self.addCleanup(process.end)
        return process

    def test_example_node(self) -> None:
        """Course 004-bridge-1, 004-bridge-11."""
        process = self.start("example_node", "__name:=example", "__ns:=robot1")
        process.wait_for_log("Fatal message")
        self.assertEqual(process.interrupt(), 0)
        name, namespace, full_name, time = said(process)[:4]
        self.assertEqual(name, "Node name: example")
        self.assertEqual(namespace, "Namespace: /robot1")
        self.assertEqual(full_name, "Fully qualified name: /robot1/example")
        self.assertRegex(time, r"^Current time: \d{19} ns$")
        for level in ("[INFO] Info", "[WARN] Warning", "[ERROR] Error", "[FATAL] Fatal"):
            self.assertTrue(process.logged(*level.split()), level)
        self.assertFalse(process.logged("Debug"))

    def test_alone_it_goes_all_the_way_as_the_course_does(self) -> None:
        process = self.start("lifecycle_aware_node")
        process.wait_for_log("default_robot: heartbeat")
        service = "/lifecycle_aware_node/change_state"
        change = rospy.ServiceProxy(service, ChangeState)
        for label in ("deactivate", "activate"):
            self.assertTrue(change(Transition(0, label)).success, label)
        self.assertEqual(process.interrupt(), 0)
        expected = ["Configuring...", "Configured for robot: default_robot"]
        expected += ["Activating...", "Active and running"]
        lines = said(process)
        begin = lines.index("Node created (unconfigured)") + 1
        steps = [text for text in lines[begin:] if "heart" not in text and "=" not in text]
        self.assertEqual(steps[:4], expected)
        # Once: deactivated by another client, the node stays inactive.
        self.assertEqual(steps.count("Activating..."), 2)

    def test_lifecycle_aware_node(self) -> None:
        """Course 004-bridge-2, err-8."""
        Server().set("/lifecycle_aware_node/robot_name", "marvin")
        process = self.start("lifecycle_aware_node", "_wait_for_manager:=true")
        service = "/lifecycle_aware_node/change_state"
        rospy.wait_for_service(service, TIMEOUT_S)
        change = rospy.ServiceProxy(service, ChangeState)
        self.assertFalse(change(Transition(0, "activate")).success)
        for label in ("configure", "activate"):
            self.assertTrue(change(Transition(0, label)).success, label)
        process.wait_for_log("marvin: heartbeat")
        for label in ("deactivate", "cleanup", "configure"):
            self.assertTrue(change(Transition(0, label)).success, label)
        self.assertEqual(process.interrupt(), 0)
        expected = ["Node created (unconfigured)"]
        expected += ["Configuring...", "Configured for robot: marvin"]
        expected += ["Activating...", "Active and running", "Deactivating...", "Deactivated"]
        expected += ["Cleaning up..."]
        expected += expected[1:3] + ["Shutting down, was inactive"]
        steps = [text for text in said(process) if "heart" not in text and "=" not in text]
        self.assertEqual(steps, expected)
        self.assertTrue(process.logged("activate is not allowed in the state unconfigured"))


if __name__ == "__main__":
    rospy.init_node("test_lifecycle_demo")
    rosrun("lifecycle_demo", "lifecycle_demo", Demos)
