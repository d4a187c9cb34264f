#!/usr/bin/env python3
"""Tests of shutting motor and set point down while a message is due."""

import os
import signal
import subprocess
import unittest
from typing import Any

import rospkg
import rospy

from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from pid_control.msg import motor_input, motor_output, set_point

SCRIPTS = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts")


class LoopEnds(unittest.TestCase):
    """Each test has a namespace, and in it the process that it starts."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]

    def start(self, name: str, **parameters: Any) -> "subprocess.Popen[bytes]":
        """Start a node, to be ended after the test."""
        given = [f"_{key}:={value}" for key, value in parameters.items()]
        node = subprocess.Popen(
            [os.path.join(SCRIPTS, name + ".py"), "__ns:=" + self.space, *given]
        )
        self.addCleanup(node.wait, TIMEOUT_S)
        self.addCleanup(node.kill)
        return node

    def end(self, node: "subprocess.Popen[bytes]") -> int:
        """Press Ctrl-C, and return the exit status."""
        node.send_signal(signal.SIGINT)
        return node.wait(TIMEOUT_S)

    def wait_for_its_end(self, recorder: MessageRecorder) -> None:
        """Wait until all is heard that a node has said which has ended."""
        wait_until(
            lambda: recorder.publishers() == 0, lambda: f"{recorder.messages()[-1:]} is not the end"
        )

    def test_motor_shutdown_sends_nothing_after_last_output(self) -> None:
        outputs = MessageRecorder(self.space + "/motor_output", motor_output)
        motor = self.start("system", system_node_rate=1e4)  # an output is due as it ends
        publisher = rospy.Publisher(
            self.space + "/motor_input", motor_input, queue_size=1, latch=True
        )
        publisher.publish(7.0, 0.0)
        outputs.wait_for(lambda heard: heard.status == "Motor Max Speed")
        self.assertEqual(self.end(motor), 0)
        self.wait_for_its_end(outputs)
        self.assertEqual(outputs.messages()[-1].status, "Motor Not Turning")

    def test_set_point_carries_its_time_and_ends_with_its_stop_value(self) -> None:
        heard = MessageRecorder(self.space + "/set_point", set_point)
        # So fast that another output is due as it ends.
        node = self.start("set_point_generator", rate=1e4, offset=3.0, stop_value=-1.0)
        heard.wait_for(lambda message: message.time > 0.5)
        self.assertEqual(self.end(node), 0)
        self.wait_for_its_end(heard)
        times = [message.time for message in heard.messages()]
        self.assertEqual(times, sorted(times))
        self.assertEqual(heard.messages()[-1].setPoint, -1.0)
        heard.close()


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rospy.init_node("test_loop_ends")
    rosrun("pid_control", "loop_ends", LoopEnds)
