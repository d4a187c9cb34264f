#!/usr/bin/env python3
"""Tests of motor, set point and controller: start, stop and live tuning."""

import os
import signal
import subprocess
import unittest
from typing import Any, Dict

import rospkg
import rospy
from rosgraph_msgs.msg import Log

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nodekit import ChangeRefused, Node, host_all, init_node
from nodekit.testing.changing import change
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.nodes.controller import Controller
from pid_control.nodes.set_point_generator import SetPointGenerator
from pid_control.nodes.system import System
from pid_control_msgs.msg import ControllerTerms

SCRIPTS = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts")
CLASSES = {"system": System, "set_point_generator": SetPointGenerator, "controller": Controller}
#: Effect of an input of 7 on the course's slide: the motor runs at its greatest speed.
MAX_SPEED = 13.0
#: How often a hosted motor publishes its output, Hz.
RATE_HZ = 200.0
#: The greatest that the controller takes: a busy machine does not reach it [s].
LONGEST_TIMEOUT_S = 60.0


class Loop(unittest.TestCase):
    """Each test has a namespace, with the nodes that it hosts in this process.

    A test of a process's end starts the node as a separate process.
    """

    node: Node  # this process's own

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.inputs = MessageRecorder(self.space + "/motor_input", motor_input)
        self.outputs = MessageRecorder(self.space + "/motor_output", motor_output)
        self.log = MessageRecorder("/rosout", Log)
        for recorder in (self.inputs, self.outputs, self.log):
            self.addCleanup(recorder.close)

    def host(self, name: str, **parameters: Any) -> Node:
        """Host a node in this process; after the test it is closed, without a last message."""
        for key, value in parameters.items():
            rospy.set_param(f"{self.space}/{name}/{key}", value)
        [node] = host_all(self.node, [(name, self.space, CLASSES[name])])
        self.addCleanup(node.close)
        return node

    def start(self, name: str, **parameters: Any) -> "subprocess.Popen[bytes]":
        """Start a node as a process, to be ended after the test."""
        given = [f"_{key}:={value}" for key, value in parameters.items()]
        node = subprocess.Popen(
            [os.path.join(SCRIPTS, name + ".py"), "__ns:=" + self.space, *given]
        )
        self.addCleanup(self.end, node, signal.SIGKILL)
        return node

    def end(self, node: "subprocess.Popen[bytes]", number: int = signal.SIGINT) -> int:
        """End a process by a signal, and return its exit status."""
        if node.poll() is None:
            node.send_signal(number)
        return node.wait(TIMEOUT_S)

    def host_motor(self) -> Node:
        """Host a motor with fewer outputs than the course's: each costs time, none is needed."""
        return self.host("system", system_node_rate=RATE_HZ)

    def host_loop(self, timeout: float = LONGEST_TIMEOUT_S) -> Dict[str, Node]:
        """Host the loop with a constant set point, and wait until the motor does that.

        :param timeout: the controller's; on a busy machine motor and set point fall silent for a
            while
        """
        nodes = {
            "system": self.host_motor(),
            "set_point_generator": self.host_set_point(),
            "controller": self.host("controller", timeout=timeout, command_timeout=0.0),
        }
        self.wait_for_speed(4.0)
        return nodes

    def host_set_point(self) -> Node:
        """Host a constant set point."""
        constant = dict(waveform="constant", amplitude=0.0, offset=4.0, rate=100.0)
        return self.host("set_point_generator", **constant)

    def wait_for_speed(self, speed: float) -> None:
        """Wait until the latest outputs have all been near a speed."""

        def rests() -> bool:
            latest = [message.output for message in self.outputs.messages()[-40:]]
            return len(latest) == 40 and all(abs(value - speed) < 0.02 for value in latest)

        wait_until(rests, lambda: f"outputs are {self.outputs.messages()[-2:]}, not {speed}")

    def wait_for_line(self, text: str) -> None:
        """Wait for a line of the log that has this text and names something of this test."""
        self.log.wait_for(lambda line: text in line.msg and self.space + "/" in line.msg)

    def wait_for_its_end(self, recorder: MessageRecorder) -> None:
        """Wait until all is heard that a node has said which has ended."""
        wait_until(
            lambda: recorder.publishers() == 0, lambda: f"{recorder.messages()[-1:]} is not the end"
        )

    def assert_stands(self) -> None:
        """Wait until the motor is at rest, with a last input of 0."""
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")
        wait_until(
            lambda: self.inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {self.inputs.messages()[-1]}",
        )

    def test_motor_constant_input_reaches_greatest_speed(self) -> None:
        """Course 003-pid-1."""
        motor = self.start("system")
        publisher = rospy.Publisher(
            self.space + "/motor_input", motor_input, queue_size=1, latch=True
        )
        standing = self.outputs.wait_for(lambda heard: True)
        self.assertEqual((standing.output, standing.status), (0.0, "Motor Not Turning"))
        publisher.publish(7.0, 0.0)
        turning = self.outputs.wait_for(lambda heard: 0.1 < heard.output < 12.9)
        self.assertEqual(turning.status, "Motor Turning")
        fast = self.outputs.wait_for(lambda heard: heard.status == "Motor Max Speed")
        self.assertEqual(fast.output, MAX_SPEED)
        times = [heard.time for heard in self.outputs.messages()]
        self.assertEqual(times, sorted(times))
        self.assertLess(abs(times[1] - times[0] - 0.001), 1e-6)
        self.assertEqual(self.end(motor), 0)
        self.wait_for_its_end(self.outputs)
        last = self.outputs.messages()[-1]
        self.assertEqual((last.output, last.status), (0.0, "Motor Not Turning"))

    def test_motor_ignores_dead_zone_and_not_finite_inputs(self) -> None:
        self.host_motor()
        publisher = rospy.Publisher(
            self.space + "/motor_input", motor_input, queue_size=1, latch=True
        )
        publisher.publish(0.5, 0.0)
        self.wait_for_speed(6.55)
        publisher.publish(float("nan"), 0.0)
        self.wait_for_line("is not finite")
        self.outputs.clear()
        self.wait_for_speed(6.55)
        publisher.publish(0.05, 0.0)
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")

    def test_controller_motor_follows_set_point(self) -> None:
        self.host_loop()
        change(self.space + "/set_point_generator", offset=-6.0)
        self.wait_for_speed(-6.0)
        answered = {message.time for message in self.inputs.messages()[-50:]}
        # An answer may be heard here before the output that it answers.
        wait_until(
            lambda: answered <= {message.time for message in self.outputs.messages()},
            lambda: f"these are no times of outputs: {answered}",
        )

    def test_controller_gain_change_does_not_jump(self) -> None:
        self.host_loop()
        terms = MessageRecorder(self.space + "/controller/terms", ControllerTerms)
        terms.wait_for(lambda heard: True)
        before = self.inputs.messages()[-1].input
        self.inputs.clear()
        change(self.space + "/controller", kp=0.02, ki=0.4, mode="PID")
        terms.clear()
        heard = terms.wait_for(lambda heard: True)
        total = heard.proportional + heard.integral + heard.derivative + heard.feed_forward
        self.assertAlmostEqual(total, heard.unlimited, delta=1e-12)
        self.assertAlmostEqual(heard.output, heard.unlimited, delta=1e-12)
        self.inputs.wait_for(lambda message: message.time >= heard.time)
        # The integral has taken up the old gain's share: with 0.08 the error would be that large.
        worst = max(abs(message.input - before) for message in self.inputs.messages())
        self.assertLess(worst, 0.01)
        terms.close()

    def test_controller_disabled_stops_motor_once(self) -> None:
        self.host_loop()
        change(self.space + "/controller", enabled=False)
        self.assert_stands()
        self.inputs.clear()
        self.outputs.clear()
        wait_until(lambda: self.outputs.count() > 40, lambda: "no outputs")
        self.assertEqual(self.inputs.messages(), [])
        change(self.space + "/controller", enabled=True)
        self.wait_for_speed(4.0)

    def test_controller_shutdown_stops_motor(self) -> None:
        self.host_motor()
        self.host_set_point()
        controller = self.start("controller", timeout=LONGEST_TIMEOUT_S, command_timeout=0.0)
        self.wait_for_speed(4.0)
        self.inputs.clear()
        wait_until(lambda: self.inputs.count() > 0, lambda: "no inputs")
        self.assertEqual(self.end(controller), 0)
        self.assert_stands()
        *before, last = [message.input for message in self.inputs.messages()]
        self.assertTrue(before)
        self.assertNotIn(0.0, before)
        self.assertEqual(last, 0.0)

    def manage(self, node: str, *transitions: str) -> None:
        """Ask a managed node for transitions, one after the other."""
        name = f"{self.space}/{node}/change_state"
        rospy.wait_for_service(name, TIMEOUT_S)
        for label in transitions:
            answer = rospy.ServiceProxy(name, ChangeState)(Transition(label=label))
            self.assertTrue(answer.success, label)

    def test_managed_controller_activation_resets(self) -> None:
        self.host_motor()
        self.host_set_point()
        controller = self.start(
            "controller", managed=True, timeout=LONGEST_TIMEOUT_S, command_timeout=0.0
        )
        self.manage("controller", "configure")
        for _ in range(2):
            # Time for an integral to grow, if it were at work.
            self.outputs.clear()
            wait_until(lambda: self.outputs.count() > 100, lambda: "no outputs")
            self.inputs.clear()
            self.manage("controller", "activate")
            self.wait_for_speed(4.0)
            first = next(heard.input for heard in self.inputs.messages() if heard.input != 0.0)
            self.assertAlmostEqual(first, 4.0 * 0.08, delta=1e-6)
            self.manage("controller", "deactivate")
            self.assert_stands()
        self.inputs.clear()
        self.assertEqual(self.end(controller), 0)
        self.wait_for_its_end(self.inputs)
        self.assertEqual(self.inputs.messages(), [])

    def test_managed_set_point_deactivation_publishes_stop_value(self) -> None:
        heard = MessageRecorder(self.space + "/set_point", set_point)
        self.addCleanup(heard.close)
        self.host("set_point_generator", managed=True, offset=3.0, stop_value=-1.0)
        for transitions in (("configure", "activate"), ("activate",)):
            self.manage("set_point_generator", *transitions)
            heard.wait_for(lambda message: message.setPoint >= 2.0)
            self.manage("set_point_generator", "deactivate")
            heard.wait_for(lambda message: message.setPoint == -1.0)
            self.assertEqual(heard.messages()[-1].setPoint, -1.0)
            heard.clear()

    def test_controller_silent_motor_gets_input_zero(self) -> None:
        nodes = self.host_loop(timeout=0.5)
        nodes["system"].close()
        self.wait_for_line("nothing for 0.5 s: the input is 0")
        wait_until(
            lambda: self.inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {self.inputs.messages()[-1]}",
        )
        self.outputs.clear()
        self.inputs.clear()
        self.host_motor()
        self.wait_for_speed(4.0)
        # The integral of before is gone: the first answer is the proportional term's. On a busy
        # machine there may be another 0 later, of a motor that turns.
        first = next(heard.input for heard in self.inputs.messages() if heard.input != 0.0)
        self.assertAlmostEqual(first, 4.0 * 0.08, delta=1e-6)

    def test_controller_killed_set_point_gets_input_zero(self) -> None:
        self.host_motor()
        given = dict(waveform="constant", amplitude=0.0, offset=4.0, rate=100.0)
        source = self.start("set_point_generator", **given)
        self.host("controller", timeout=LONGEST_TIMEOUT_S, command_timeout=2.0)
        self.wait_for_speed(4.0)
        self.end(source, signal.SIGKILL)  # without a stop_value
        self.wait_for_line("nothing for 2 s: the input is 0")
        self.assert_stands()
        self.start("set_point_generator", **given)
        self.wait_for_speed(4.0)

    def test_controller_restarted_motor_gets_previous_input(self) -> None:
        nodes = self.host_loop()
        nodes["system"].close()
        self.wait_for_its_end(self.outputs)
        self.outputs.clear()
        self.host_motor()
        self.wait_for_line("the motor was restarted")
        self.wait_for_speed(4.0)
        inputs = self.inputs.messages()
        # dt is 0 at the first output, because its time is before the last motor's.
        before, first = next(
            (last, first) for last, first in zip(inputs, inputs[1:]) if first.time < last.time
        )
        self.assertAlmostEqual(first.input, before.input, delta=1e-6)

    def test_controller_manual_to_automatic_does_not_jump(self) -> None:
        self.host_loop()
        change(self.space + "/controller", mode="manual", manual_output=0.4)
        self.wait_for_speed(5.24)
        for mode in ("PI", "manual", "PID"):
            self.inputs.clear()
            change(self.space + "/controller", mode=mode)
            enough = self.inputs.count() + 50
            wait_until(lambda: self.inputs.count() > enough, lambda: "no inputs")
            # A jump would be the proportional term's, 0.1; an integral needs time for that.
            inputs = [0.4, *(message.input for message in self.inputs.messages())]
            steps = [abs(after - one) for one, after in zip(inputs, inputs[1:])]
            self.assertLess(max(steps), 0.05, (mode, inputs))
            if mode != "manual":
                change(self.space + "/controller", mode="manual")
                self.wait_for_speed(5.24)

    def test_controller_limits_in_wrong_order_are_rejected(self) -> None:
        self.host_loop()
        with self.assertRaisesRegex(ChangeRefused, "output_min must be below output_max"):
            change(self.space + "/controller", output_min=2.0)
        self.wait_for_speed(4.0)

    def test_controller_manual_output_is_published_and_clipped(self) -> None:
        """Course 003-pid-3."""
        self.host_loop()
        change(self.space + "/controller", mode="manual", manual_output=0.5)
        self.wait_for_speed(6.55)
        change(self.space + "/controller", manual_output=-3.0)
        self.inputs.wait_for(lambda heard: heard.input == -1.0)
        change(self.space + "/controller", mode="PI")
        self.wait_for_speed(4.0)

    def test_course_names_set_only_unset_parameters(self) -> None:
        """Course 003-pid-2."""
        rospy.set_param(self.space + "/system_param_K", 5.0)
        rospy.set_param(self.space + "/system_max_speed", 4.0)
        arguments = ["__ns:=" + self.space, "_system_max_speed:=6.0"]
        node = Process(os.path.join(SCRIPTS, "system.py"), arguments)
        self.addCleanup(node.end)
        # /rosout may not be connected yet when a node says its first words.
        node.wait_for_log(
            f"parameters copied from the course's names: {self.space}/system_param_K: 5.0"
        )
        self.outputs.wait_for(lambda heard: True)
        self.assertEqual(rospy.get_param(self.space + "/system/system_param_K"), 5.0)
        self.assertEqual(rospy.get_param(self.space + "/system/system_max_speed"), 6.0)
        node.wait_for_log(
            f"{self.space}/system_max_speed: 4.0 is ignored, because"
            f" {self.space}/system/system_max_speed: 6.0 is set; to use it at the next start:"
            f" rosparam delete {self.space}/system/system_max_speed"
        )
        self.assertFalse(
            [line for line in node.logged() if "system_param_K: 5.0 is ignored" in line]
        )


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    Loop.node = init_node("test_loop")
    Loop.node.start()
    rosrun("pid_control", "loop", Loop)
