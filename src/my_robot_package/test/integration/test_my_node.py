#!/usr/bin/env python3
"""A node created within the test, as in the course's book."""

import threading
import unittest
from typing import List

import rospy
import yaml
from std_msgs.msg import String
from std_srvs.srv import Trigger

from my_robot_package.nodes.my_node import MyRobotNode
from my_robot_package.nodes.service_client_node import ServiceClientNode
from nodekit import Node, init_node
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S


class TestMyRobotNode(unittest.TestCase):
    """The node itself, not its process. Course 002-pkg-11."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.node = init_node("my_robot_node")
        cls.robot = MyRobotNode(cls.node)
        cls.node.start()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.node.close()

    def test_node_initialization(self) -> None:
        self.assertEqual(self.node.name, "/my_robot_node")
        self.assertTrue(self.node.is_up)

    def test_parameter_declaration(self) -> None:
        """They are declared, and on the server. The book's own node fails here."""
        described = yaml.safe_load(rospy.ServiceProxy("~describe", Trigger)().message)
        names = [entry["name"] for entry in described]
        topics = ["sensor_topics", "control_topics"]
        self.assertEqual(names, ["robot_name", "max_velocity", "safety_mode", *topics])
        for name in names:
            self.assertTrue(rospy.has_param("~" + name), name)

    def test_it_says_hello(self) -> None:
        recorder = MessageRecorder("topic_name", String)
        self.addCleanup(recorder.close)
        recorder.wait_for(lambda message: message.data == "Hello from my_robot_node")

    def test_client_that_is_closed_waits_no_longer(self) -> None:
        made: List[ServiceClientNode] = []

        def make(node: Node) -> None:
            made.append(ServiceClientNode(node))

        self.node.host("client", "/closed", make).close()
        thread = threading.Thread(target=made[0].send_requests, args=(0.0,), daemon=True)
        thread.start()
        thread.join(TIMEOUT_S)
        self.assertFalse(thread.is_alive())


if __name__ == "__main__":
    rosrun("my_robot_package", "my_robot_node", TestMyRobotNode)
