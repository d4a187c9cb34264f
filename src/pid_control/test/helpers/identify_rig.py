"""Test rig for the commands identify and tune: a hosted motor, and temporary files."""

import os
import shutil
import tempfile
import unittest

import rospkg
import rospy

from nodekit import Node, host_all
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from pid_control.msg import motor_input, motor_output
from pid_control.nodes.system import System

SCRIPTS = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts")


class IdentifyCase(unittest.TestCase):
    """Test case with a namespace, and a folder for files, for each test."""

    node: Node  # this process's own, which hosts the motors

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.inputs = MessageRecorder(self.space + "/motor_input", motor_input)
        self.outputs = MessageRecorder(self.space + "/motor_output", motor_output)
        self.addCleanup(self.inputs.close)
        self.addCleanup(self.outputs.close)

    def start(self, name: str, *arguments: str) -> Process:
        """Start a command, to be ended after the test."""
        process = Process(os.path.join(SCRIPTS, name), ["__ns:=" + self.space, *arguments])
        self.addCleanup(process.end)
        return process

    def host_motor(self) -> Node:
        """Host a motor with 200 outputs a second; closed, it falls silent."""
        rospy.set_param(self.space + "/system/system_node_rate", 200.0)
        [motor] = host_all(self.node, [("system", self.space, System)])
        self.addCleanup(motor.close)
        self.outputs.wait_for(lambda heard: True)
        return motor

    def file(self, name: str) -> str:
        """Return the path of a file of this test."""
        return os.path.join(self.folder, name)

    def assert_stopped(self) -> None:
        """Wait until the motor is at rest, with a last input of 0."""
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")
        self.wait_for_last_input()

    def wait_for_last_input(self) -> None:
        """Wait until the last input is 0."""
        wait_until(
            lambda: self.inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {self.inputs.messages()[-1]}",
        )
