#!/usr/bin/env python3
"""Use the node as its users do: launch it, subscribe, change a parameter."""

import unittest

import rospy
from std_msgs.msg import String

from nodekit.testing.launching import launched
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun


class MyNodeTest(unittest.TestCase):
    """The launch file starts the node."""

    def test_publishes_its_text_and_applies_a_change(self) -> None:
        recorder = MessageRecorder("/test/output", String)
        with launched("package_name my_node.launch rate:=20 __ns:=test") as launch:
            recorder.wait_for(lambda message: message.data == "Hello")
            launch.graph.set_parameter("/test/my_node/text", "Good morning")
            recorder.wait_for(lambda message: message.data == "Good morning")


if __name__ == "__main__":
    rospy.init_node("test_my_node")
    rosrun("package_name", "my_node", MyNodeTest)
