#!/usr/bin/env python3
"""Enabling of a motor by its set point while either restarts or another client interferes."""

import os
import signal
import subprocess
import time
import unittest
from typing import Dict, List

import rospkg
import rospy
from helpers.putting_back import wait_for_put_backs
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float32, String

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from motor_control_msgs.srv import SetProcessBool, SetProcessBoolResponse
from nodekit.testing.changing import change
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

SCRIPTS = os.path.join(rospkg.RosPack().get_path("motor_control"), "scripts")


class EnableSequence(unittest.TestCase):
    """Each test has a namespace, and in it the nodes that it starts."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.inputs = MessageRecorder(self.space + "/motor_input_u", Float32)
        self.speeds = MessageRecorder(self.space + "/motor_speed_y", Float32)
        self.states = MessageRecorder(self.space + "/motor_state", String)
        self.log = MessageRecorder("/rosout", Log)
        self.enable = rospy.ServiceProxy(self.space + "/EnableProcess", SetProcessBool)
        self.change_state = rospy.ServiceProxy(self.space + "/sp_gen/change_state", ChangeState)
        self.nodes: Dict[str, "subprocess.Popen[bytes]"] = {}

    def start(self, program: str, name: str, *given: str) -> "subprocess.Popen[bytes]":
        """Start a node, to be ended after the test."""
        node = subprocess.Popen(
            [os.path.join(SCRIPTS, program), "__ns:=" + self.space, "__name:=" + name, *given]
        )
        self.addCleanup(self.end, node, signal.SIGKILL)
        self.nodes[name] = node
        return node

    def alive(self) -> List[str]:
        """Return the names of the nodes that run."""
        return [name for name, node in self.nodes.items() if node.poll() is None]

    def end(self, node: "subprocess.Popen[bytes]", number: int) -> int:
        """End a node by a signal, and return its exit status."""
        if node.poll() is None:
            node.send_signal(number)
        return node.wait(TIMEOUT_S)

    def start_motor(self) -> "subprocess.Popen[bytes]":
        """Start a motor, and wait until it can be enabled."""
        self.states.clear()
        motor = self.start("dc_motor.py", "motor_sys")
        self.wait_for_state("waiting")
        return motor

    def start_set_point(self, *given: str) -> "subprocess.Popen[bytes]":
        return self.start("set_point.py", "sp_gen", *given)

    def manage_set_point(self, *transitions: str) -> None:
        for transition in transitions:
            answer = self.change_state(Transition(label=transition))
            self.assertTrue(answer.success, transition)

    def wait_for_state(self, state: str) -> None:
        self.states.wait_for(lambda heard: heard.data == state)

    def wait_for_line(self, text: str) -> None:
        self.log.wait_for(lambda line: text in line.msg and line.name.startswith(self.space))

    def assert_both_run(self) -> None:
        for recorder in (self.inputs, self.speeds):
            recorder.clear()
            recorder.wait_for(lambda heard: heard.data != 0.0)

    def assert_both_are_silent(self) -> None:
        """Listen for some periods of each node that runs."""
        for recorder in (self.inputs, self.speeds):
            recorder.clear()
        for name in self.alive():
            wait_for_put_backs(f"{self.space}/{name}", 5)
        self.assertEqual(self.inputs.messages() + self.speeds.messages(), [])

    def test_set_point_first(self) -> None:
        self.start_set_point()
        for _ in range(2):
            self.wait_for_line(
                f"waiting for the motor: {self.space}/EnableProcess cannot be called: "
            )
            self.log.clear()
        self.assertEqual(self.inputs.messages(), [])
        self.start("dc_motor.py", "motor_sys")
        self.wait_for_state("enabled")
        self.assert_both_run()

    def test_motor_first_and_disabling_stops_both_until_somebody_enables(self) -> None:
        self.start_motor()
        self.assertEqual(self.speeds.messages(), [])
        self.start_set_point()
        self.assert_both_run()
        self.wait_for_state("enabled")
        self.assertEqual([heard.data for heard in self.states.messages()], ["waiting", "enabled"])
        self.assertEqual(self.enable(True).message, "enabled already")
        self.assertTrue(self.enable(False).success)
        self.wait_for_line("the motor is disabled")
        # Each publishes a final 0.
        for recorder in (self.inputs, self.speeds):
            wait_until(lambda: recorder.messages()[-1].data == 0.0, lambda: "there is no last 0")
        self.assert_both_are_silent()
        self.assertEqual(self.enable(True).message, "enabled")
        self.assert_both_run()
        change(self.space + "/sp_gen", omega=40.0)  # more than its rate can carry
        self.wait_for_line("40 rad/s is above the Nyquist frequency of 31.4159 rad/s")

    def test_motor_that_is_killed_and_comes_back(self) -> None:
        motor = self.start_motor()
        self.start_set_point()
        self.assert_both_run()
        self.end(motor, signal.SIGKILL)
        self.wait_for_line("the motor is gone")
        wait_until(lambda: self.inputs.messages()[-1].data == 0.0, lambda: "there is no last 0")
        self.assert_both_are_silent()
        self.wait_for_line(f"waiting for the motor: {self.space}/EnableProcess ")
        self.states.clear()
        self.start("dc_motor.py", "motor_sys")
        self.wait_for_state("enabled")
        self.assert_both_run()

    def test_disabled_motor_that_starts_anew_stays_off(self) -> None:
        motor = self.start_motor()
        self.start_set_point()
        self.assert_both_run()
        self.enable(False)
        self.wait_for_line("the motor is disabled")
        self.assertEqual(self.end(motor, signal.SIGINT), 0)
        self.wait_for_line("the motor is gone")
        self.start_motor()
        self.assert_both_are_silent()
        self.assertEqual(self.enable(True).message, "enabled")
        self.assert_both_run()

    def test_motor_disabled_before_it_was_enabled_says_so_and_a_set_point_enables_it(self) -> None:
        self.start_motor()
        answer = self.enable(False)
        self.assertEqual((answer.success, answer.message), (True, "disabled already"))
        self.wait_for_state("disabled")
        self.start_set_point()
        self.assert_both_run()

    def test_refusals_and_failures_are_retried_after_growing_pauses(self) -> None:
        calls: List[float] = []

        def answer(_request: object) -> SetProcessBoolResponse:
            calls.append(time.monotonic())
            if len(calls) == 2:
                raise RuntimeError("a defect of the motor")
            return SetProcessBoolResponse(len(calls) > 4, f"call {len(calls)}")

        service = rospy.Service(self.space + "/EnableProcess", SetProcessBool, answer)
        self.addCleanup(service.shutdown)
        self.start_set_point()
        self.inputs.wait_for(lambda heard: True)
        self.assertEqual(len(calls), 5)
        self.wait_for_line("waiting for the motor: call 4")
        # A pause counts from the answer, so however slow the machine is, it cannot look shorter.
        for pause, before, after in zip((0.2, 0.4, 0.8, 1.0), calls, calls[1:]):
            self.assertGreater(after - before, pause)

    def test_calls_while_the_motor_shuts_down_are_answered_or_fail_at_once(self) -> None:
        motor = self.start_motor()
        self.assertTrue(self.enable(True).success)
        motor.send_signal(signal.SIGINT)
        with self.assertRaises(rospy.ServiceException):
            while motor.poll() is None:
                answer = self.enable(True)
                self.assertIn(answer.message, ("enabled already", "the motor is shutting down"))
            self.enable(True)
        self.assertEqual(motor.wait(TIMEOUT_S), 0)

    def test_set_point_that_ends_has_its_stop_value_be_the_last_input(self) -> None:
        self.start_motor()
        # So often that another one is due as it ends.
        set_point = self.start_set_point("_rate:=10000", "_offset:=2", "_stop_value:=0.25")
        self.assert_both_run()
        self.assertEqual(self.end(set_point, signal.SIGINT), 0)
        # Until then there may be some left to read.
        wait_until(lambda: self.inputs.publishers() == 0, lambda: "it is still connected")
        self.assertEqual(self.inputs.messages()[-1].data, 0.25)
        self.assertEqual([heard.data for heard in self.inputs.messages()].count(0.25), 1)

    def test_managed_set_point_stops_the_motor_when_it_is_deactivated(self) -> None:
        self.start_motor()
        set_point = self.start_set_point("_managed:=true", "_offset:=2", "_stop_value:=0.25")
        self.change_state.wait_for_service(TIMEOUT_S)
        for transitions in (("configure", "activate"), ("activate",)):
            self.manage_set_point(*transitions)
            self.assert_both_run()
            self.manage_set_point("deactivate")
            self.inputs.wait_for(lambda heard: heard.data == 0.25)
            self.assertEqual(self.inputs.messages()[-1].data, 0.25)
        self.inputs.clear()
        self.assertEqual(self.end(set_point, signal.SIGINT), 0)
        self.assertEqual(self.inputs.messages(), [])

    def test_set_point_that_waits_ends_cleanly(self) -> None:
        set_point = self.start_set_point()
        self.wait_for_line(f"waiting for the motor: {self.space}/EnableProcess cannot be called: ")
        self.assertEqual(self.end(set_point, signal.SIGINT), 0)


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would the nodes.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rospy.init_node("test_enable_sequence", disable_signals=True)
    rosrun("motor_control", "enable_sequence", EnableSequence)
