#!/usr/bin/env python3
"""A motor and its set point in one process: each receives the other's messages."""

import os
import signal
import subprocess
import sys
import unittest
from typing import Any, List

import rospy
from std_msgs.msg import Float32

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

HELPER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "helpers")
PAIRS = [f"/pair{number}" for number in range(3)]


class Hosted(unittest.TestCase):
    """One process with three fast pairs: it would hang if two callbacks waited for each other."""

    process: "subprocess.Popen[bytes]"
    graph: Graph

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_hosted")
        cls.graph = Graph()
        for pair in PAIRS:
            rospy.set_param(pair + "/motor_sys/sample_time", 0.002)
            rospy.set_param(pair + "/sp_gen/rate", 500.0)
        cls.process = subprocess.Popen([sys.executable, os.path.join(HELPER, "hosted_motors.py")])

    def recorder(self, topic: str, kind: Any) -> MessageRecorder:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def test_motors_follow_their_set_points_and_go_on_when_they_are_retimed(self) -> None:
        speeds = [self.recorder(pair + "/motor_speed_y", Float32) for pair in PAIRS]
        for round_ in range(3):
            for speed in speeds:
                speed.clear()
                speed.wait_for(lambda message: abs(message.data) > 0.01)
                wait_until(lambda: speed.count() > 300, lambda: f"{speed.count()} speeds")
            for pair in PAIRS:
                rospy.set_param(pair + "/sp_gen/amplitude", 2.0 + round_)
                rospy.set_param(pair + "/motor_sys/sys_gain_K", 1.0 + round_)
        names = {f"{pair}/{name}" for pair in PAIRS for name in ("motor_sys", "sp_gen")}
        held: List[str] = rospy.get_param_names()
        self.assertEqual(
            {name for name in names if name + "/rate" in held},
            {name for name in names if name.endswith("sp_gen")},
        )

    @classmethod
    def tearDownClass(cls) -> None:
        cls.process.send_signal(signal.SIGINT)
        status = cls.process.wait(TIMEOUT_S)
        assert status == 0, f"exit status {status}"


if __name__ == "__main__":
    rosrun("motor_control", "hosted", Hosted)
