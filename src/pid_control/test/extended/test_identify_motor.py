#!/usr/bin/env python3
"""Tests of identify with a clock that waits for it, so that no machine is too slow."""

import os
import tempfile
import unittest
from functools import partial
from typing import Callable
from xmlrpc.client import ServerProxy

import rosgraph
import rospkg
import rospy
from rosgraph_msgs.msg import Clock

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from pid_control.identification.model_file import read_model
from pid_control.msg import motor_input, motor_output

IDENTIFY = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts", "identify")
PERIOD_S = 0.005


class IdentifyMotor(unittest.TestCase):
    """The motor of the launch file: dead time 0.02 s, greatest speed 9."""

    def setUp(self) -> None:
        self.clock, self.motor_clock = (
            rospy.Publisher(topic, Clock, queue_size=10) for topic in ("/clock", "/motor_clock")
        )
        self.inputs = MessageRecorder("motor_input", motor_input)
        self.outputs = MessageRecorder("motor_output", motor_output)
        self.time = 1.0
        graph = Graph()
        graph.wait_until_heard(rospy.get_name(), "/motor_clock", "/system")
        graph.wait_until_heard("/system", "/motor_output", rospy.get_name())
        self.motor = ServerProxy(rosgraph.Master("/test").lookupNode("/system"))

    @staticmethod
    def received(node: ServerProxy, topic: str) -> int:
        """Return how many messages of a topic a node has got."""
        subscriptions = node.getBusStats("/test")[2][1]
        return sum(link[2] for name, links in subscriptions if name == topic for link in links)

    def step(self, before_motor: Callable[[], None] = lambda: None) -> None:
        """Move the clock, and then the motor's; wait until the motor has published.

        :param before_motor: called between both
        """
        before = self.outputs.count()
        self.time += PERIOD_S
        now = Clock(rospy.Time.from_sec(self.time))
        self.clock.publish(now)
        before_motor()
        self.motor_clock.publish(now)
        wait_until(lambda: self.outputs.count() > before, lambda: f"no output at {self.time}")

    def drive(self, command: Process) -> None:
        """Advance the clocks until the command has ended; each node waits for the other.

        Without that, inputs and outputs would be a period too early at random.
        """
        graph = Graph()
        graph.wait_until_heard(rospy.get_name(), "/clock", "/identify")
        graph.wait_until_heard("/identify", "/motor_input", rospy.get_name())
        graph.wait_until_heard("/identify", "/motor_input", "/system")
        graph.wait_until_heard("/system", "/motor_output", "/identify")
        identify = ServerProxy(rosgraph.Master("/test").lookupNode("/identify"))

        def is_over() -> bool:
            return command.popen.poll() is not None

        def wait_for(condition: Callable[[], bool], what: str) -> None:
            wait_until(
                lambda: is_over() or condition(),
                lambda: f"no {what} at {self.time}: {command.logged()}",
            )

        def wait_for_input(clocks: int, sent: int) -> None:
            wait_for(lambda: self.received(identify, "/clock") > clocks, "clock")
            if sent:  # it has begun, at the motor's first message
                wait_for(lambda: self.inputs.count() > sent, "input")
                wait_for(
                    lambda: self.received(self.motor, "/motor_input") >= self.inputs.count(),
                    "input at the motor",
                )

        while not is_over():
            clocks, outputs = (self.received(identify, n) for n in ("/clock", "/motor_output"))
            self.step(partial(wait_for_input, clocks, self.inputs.count()))
            wait_for(
                lambda before=outputs: self.received(identify, "/motor_output") > before, "output"
            )

    def test_identify_running_motor_finds_its_parameters(self) -> None:
        """Course 003-pid-6."""
        with tempfile.TemporaryDirectory() as folder:
            model, picture = os.path.join(folder, "model.yaml"), os.path.join(folder, "fit.svg")
            arguments = [
                "--seconds",
                "4",
                "--least",
                "-0.5",
                "--model",
                model,
                "--picture",
                picture,
            ]
            self.step()
            command = Process(IDENTIFY, arguments)
            self.addCleanup(command.end)
            self.drive(command)
            self.assertEqual(command.wait(), 0, command.logged())
            with open(model) as file:
                found = read_model(file.read())
            with open(picture) as file:
                self.assertIn("</svg>", file.read())
        given = [message.input for message in self.inputs.messages()]
        self.assertEqual((min(given), max(given), given[-1]), (-0.5, 1.0, 0.0))
        self.assertAlmostEqual(found.gain, 13.1, delta=0.1)
        self.assertAlmostEqual(found.time_constant, 0.04, delta=0.001)
        # The motor samples its input every 2 ms, which is 1 ms of dead time in the mean; and its
        # clock is a period behind when it receives an input.
        self.assertAlmostEqual(found.dead_time, 0.021 - PERIOD_S, delta=0.001)
        self.assertAlmostEqual(found.dead_zone, 0.05, delta=0.01)
        self.assertAlmostEqual(found.limit, 9.0, delta=0.05)
        self.assertTrue(command.logged("63.2 % reading"))
        for _ in range(200):  # until it is at rest, at most 1 s of its time
            self.step()
        self.assertEqual(self.outputs.messages()[-1].status, "Motor Not Turning")


if __name__ == "__main__":
    rospy.init_node("test_identify_motor")
    rosrun("pid_control", "identify_motor", IdentifyMotor)
