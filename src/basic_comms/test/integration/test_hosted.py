#!/usr/bin/env python3
"""A talker and a listener hosted in one process behave like separate nodes."""

import os
import unittest

import rospy
from std_msgs.msg import String

from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

HELPER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "helpers", "hosted_talk.py")


class Hosted(unittest.TestCase):
    """The process is started by the test."""

    def test_talker_and_listener(self) -> None:
        rospy.set_param("/lab/Message", "from the group")
        process = Process(HELPER)
        self.addCleanup(process.end)
        recorder = MessageRecorder("/lab/chatter", String)
        self.addCleanup(recorder.close)
        recorder.wait_for(lambda message: message.data.startswith("from the group "))
        rospy.set_param("/lab/talker/Message", "my own")
        recorder.wait_for(lambda message: message.data.startswith("my own "))
        process.wait_for_log("I heard 'my own", "from /hosted")
        rospy.set_param("/lab/talker/rate", 200.0)
        wait_until(lambda: recorder.count() > 100, lambda: f"{recorder.count()} messages")
        self.assertEqual(process.interrupt(), 0)
        self.assertEqual(process.logged("Traceback"), [])


if __name__ == "__main__":
    rospy.init_node("test_hosted")
    rosrun("basic_comms", "hosted", Hosted)
