"""Test rig for the judge with a real plant: a motor hosted by the test."""

import os
import pathlib
import signal
import unittest
from typing import Dict, List, Optional

import rosgraph
import rospkg
import rospy

from nodekit import Node, host_all
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.nodes.system import System

PACKAGE = rospkg.RosPack().get_path("pid_control")
#: Number of tries on a busy machine.
ATTEMPTS = 10
TOPICS = ("/motor_input", "/motor_output", "/set_point")


class RealPlantCase(unittest.TestCase):
    """Test case with a namespace, in which it judges, for each test."""

    node: Node  # this process's own, which hosts the motors

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        # A student's controller, which does not stop the motor: only the judge does.
        self.remappings = [f"{topic}:={self.space}{topic}" for topic in TOPICS]
        self.controller = [self.script_of("good_loop.py"), *self.remappings]
        # After a failed test its processes may remain; the judge ends before.
        self.addCleanup(self.end_controllers)

    @staticmethod
    def script_of(name: str) -> str:
        """Return the path of a controller of the tests."""
        return os.path.join(PACKAGE, "test", "controllers", name)

    def start(
        self, name: str, *words: str, environment: Optional[Dict[str, str]] = None
    ) -> Process:
        """Start a script in the namespace, to be ended after the test."""
        variables = {"ROS_NAMESPACE": self.space, **(environment or {})}
        process = Process(os.path.join(PACKAGE, "scripts", name), list(words), variables)
        self.addCleanup(process.end)
        return process

    def start_judge(self, *words: str) -> Process:
        """Start the judge with a real plant, and wait until its controller turns the motor.

        A busy machine may make the motor silent meanwhile: the judge is then started again.
        """
        for _ in range(ATTEMPTS):
            self.wait_for_standstill()
            self.outputs.clear()
            judge = self.start("judge", "--real-plant", *words)
            wait_until(lambda: judge.popen.poll() is not None or self.turns(), lambda: "it stands")
            if self.turns():
                return judge
            self.assertEqual(judge.wait(), 125, judge.logged())
        raise AssertionError(judge.logged())

    def turns(self) -> bool:
        """Return whether the motor has turned quickly since its recorder was cleared."""
        return any(heard.output > 4.0 for heard in self.outputs.messages())

    def host_motor(self) -> Node:
        """Host a motor, and record its topics; closed, it is silent."""
        self.wanted = MessageRecorder(self.space + "/set_point", set_point)
        self.inputs = MessageRecorder(self.space + "/motor_input", motor_input)
        self.outputs = MessageRecorder(self.space + "/motor_output", motor_output)
        for recorder in (self.wanted, self.inputs, self.outputs):
            self.addCleanup(recorder.close)
        rospy.set_param(self.space + "/system/system_node_rate", 200.0)
        [motor] = host_all(self.node, [("system", self.space, System)])
        self.addCleanup(motor.close)
        self.outputs.wait_for(lambda heard: True)
        return motor

    def assert_refused(self, says: str, *words: str, **environment: str) -> None:
        """Have the judge refuse something, with its status and this text."""
        judge = self.start("judge", *words, environment=environment)
        self.assertEqual(judge.wait(), 125)
        self.assertTrue(judge.logged("not judged: ", says), (says, judge.logged()))
        self.assertFalse(judge.logged("Traceback"))

    def controllers(self) -> List[int]:
        """Return the processes that go by this test's remappings: its controllers."""
        mark = self.remappings[0].encode()
        found = []
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if mark in (process / "cmdline").read_bytes().split(b"\0"):
                    found.append(int(process.name))
            except OSError:
                continue  # it has just ended
        return found

    def assert_stopped(self) -> None:
        """Wait until the motor is at rest, with a last input of 0, and no controller runs."""
        self.assertEqual(self.controllers(), [])
        self.wait_for_standstill()
        self.wait_for_last_input()

    def wait_for_standstill(self) -> None:
        """Wait until the motor is at rest."""
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")

    def wait_for_last_input(self) -> None:
        """Wait until the last input is 0."""
        wait_until(
            lambda: self.inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {self.inputs.messages()[-1]}",
        )

    def assert_left_alone(self) -> None:
        """Wait until the motor is at rest, the last messages are 0, and no publisher is left."""
        self.assert_stopped()
        wait_until(
            lambda: self.wanted.messages()[-1].setPoint == 0.0,
            lambda: f"the last set point is {self.wanted.messages()[-1]}",
        )
        publishers = dict(rosgraph.Master("/test").getSystemState()[0])
        for topic in ("/motor_input", "/set_point"):
            self.assertNotIn(self.space + topic, publishers)

    def end_controllers(self) -> None:
        """Kill what controllers are left."""
        for controller in self.controllers():
            os.kill(controller, signal.SIGKILL)
