#!/usr/bin/env python3
"""The judge with a motor that is there already: what it refuses, and that it stops the motor."""

import os
import pathlib
import signal
import tempfile
import unittest
from typing import Dict, List, Optional

import rosgraph
import rospkg
import rospy

from nodekit.testing.graph import Graph
from nodekit.testing.hearing import Ear
from nodekit.testing.processes import Process, free_port
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from pid_control.msg import motor_input, motor_output, set_point

PACKAGE = rospkg.RosPack().get_path("pid_control")
#: A controller that ignores Ctrl-C.
STUBBORN = """#!/usr/bin/env python3
import signal, sys
sys.path.insert(0, {folder!r})
import rospy
from student import Student
rospy.init_node("controller")
signal.signal(signal.SIGINT, signal.SIG_IGN)
Student().run()
"""
TOPICS = ("/motor_input", "/motor_output", "/set_point")


class RealPlant(unittest.TestCase):
    """Each test has a namespace, in which it judges."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        # A student's, whose last input is any: nobody but the judge stops the motor.
        self.remappings = [f"{topic}:={self.space}{topic}" for topic in TOPICS]
        self.controller = [self.script_of("good_loop.py"), *self.remappings]
        # Where a test fails, what it has started may be left; the judge ends before.
        self.addCleanup(self.end_controllers)

    @staticmethod
    def script_of(name: str) -> str:
        return os.path.join(PACKAGE, "test", "controllers", name)

    def start(
        self, name: str, *words: str, environment: Optional[Dict[str, str]] = None
    ) -> Process:
        variables = {"ROS_NAMESPACE": self.space, **(environment or {})}
        process = Process(os.path.join(PACKAGE, "scripts", name), list(words), variables)
        self.addCleanup(process.end)
        return process

    def start_motor(self) -> Process:
        """Start a motor, and hear it and what it is told."""
        self.wanted = Ear(self.space + "/set_point", set_point)
        self.inputs = Ear(self.space + "/motor_input", motor_input)
        self.outputs = Ear(self.space + "/motor_output", motor_output)
        motor = self.start("system.py", "_system_node_rate:=200")
        self.outputs.wait_for(lambda heard: True)
        return motor

    def assert_refused(self, says: str, *words: str, **environment: str) -> None:
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
        """Wait until the motor stands, with 0 the last input, and no controller runs."""
        self.assertEqual(self.controllers(), [])
        self.outputs.forget()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")
        self.wait_for_last_input()

    def wait_for_last_input(self) -> None:
        """Wait until the last input is 0."""
        wait_until(
            lambda: self.inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {self.inputs.messages()[-1]}",
        )

    def assert_left_alone(self) -> None:
        """Wait until the motor stands, with 0 the last input and set point, and nobody there."""
        self.assert_stopped()
        wait_until(
            lambda: self.wanted.messages()[-1].setPoint == 0.0,
            lambda: f"the last set point is {self.wanted.messages()[-1]}",
        )
        publishers = dict(rosgraph.Master("/test").getSystemState()[0])
        for topic in ("/motor_input", "/set_point"):
            self.assertNotIn(self.space + topic, publishers)

    def test_motor_is_stopped_at_ctrl_c(self) -> None:
        self.start_motor()
        judge = self.start("judge", "--real-time", "--real-plant", *self.controller)
        self.outputs.wait_for(lambda heard: heard.output > 4.0)
        self.assertEqual(judge.interrupt(), 130)
        self.assertFalse(judge.logged("Traceback"))
        self.assert_left_alone()

    def test_motor_is_stopped_where_the_terminal_is_closed(self) -> None:
        self.start_motor()
        judge = self.start("judge", "--real-plant", *self.controller)
        self.outputs.wait_for(lambda heard: heard.output > 4.0)
        judge.popen.send_signal(signal.SIGHUP)
        self.assertEqual(judge.wait(), 128 + signal.SIGHUP)
        self.assert_left_alone()

    def test_motor_is_stopped_where_the_node_is_shut_down(self) -> None:
        self.start_motor()
        judge = self.start("judge", "--real-plant", *self.controller)
        self.outputs.wait_for(lambda heard: heard.output > 4.0)
        Graph().kill(self.space + "/judge")
        self.assertEqual(judge.wait(), 125)
        self.assertTrue(judge.logged("not judged: the node was shut down"), judge.logged())
        self.assert_stopped()

    def test_controller_that_ignores_ctrl_c_is_ended_at_a_second_one_too(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "stubborn.py"
            script.write_text(STUBBORN.format(folder=os.path.dirname(self.controller[0])))
            script.chmod(0o755)
            self.start_motor()
            judge = self.start("judge", "--real-plant", str(script), *self.remappings)
            self.outputs.wait_for(lambda heard: heard.output > 4.0)
            self.wanted.forget()
            judge.popen.send_signal(signal.SIGINT)
            # The judge asks for no speed, and waits for the controller.
            self.wanted.wait_for(lambda heard: heard.setPoint == 0.0)
            self.assertEqual(judge.interrupt(), 130)
        self.assert_stopped()

    def end_controllers(self) -> None:
        for controller in self.controllers():
            os.kill(controller, signal.SIGKILL)

    def test_controller_has_its_parameters_beside_a_real_plant(self) -> None:
        """Its launch file gives it no integral part."""
        self.start_motor()
        with tempfile.TemporaryDirectory() as folder:
            gains = pathlib.Path(folder) / "gains.yaml"
            gains.write_text("{kp: 0.05, ki: 0.0}\n")
            words = ["pid_control", "motor_control.launch", f"control_config:={gains}"]
            for _ in range(3):
                judge = self.start("judge", "--real-plant", "--only", "steps", *words)
                judge.wait()
                if not judge.logged("this machine is too busy"):
                    break
            self.assertEqual(judge.wait(), 1)
        self.assertTrue(judge.logged("steps: steady error "), judge.logged())
        self.assert_left_alone()

    def test_motor_that_falls_silent_is_given_up(self) -> None:
        motor = self.start_motor()
        judge = self.start("judge", "--real-plant", *self.controller)
        self.outputs.wait_for(lambda heard: heard.output > 4.0)
        motor.end()
        self.assertEqual(judge.wait(), 125)
        self.assertTrue(judge.logged("the plant is silent: nothing on", "motor_output for 0.8 s"))
        self.wait_for_last_input()

    def test_what_cannot_be_judged_is_refused_by_name(self) -> None:
        plant = ("--real-plant", *self.controller)
        nobody = f"nobody publishes {self.space}/motor_output"
        self.assert_refused("there is no plant: " + nobody, *plant)
        self.start_motor()
        self.assert_refused(
            "held is not for a real plant: there are steps, ramp, sine, windup",
            "--real-plant",
            "--only",
            "held",
            *self.controller,
        )
        no_master = f"http://localhost:{free_port()}"
        self.assert_refused("on your own master", *plant, ROS_MASTER_URI=no_master)
        self.start("set_point_generator.py")
        self.wanted.wait_for(lambda heard: True)
        generator = self.space + "/set_point_generator"
        self.assert_refused(f"{generator} publishes {self.space}/set_point: end that", *plant)
        self.assertEqual(self.inputs.messages(), [])

    def test_real_time_is_for_those_who_go_by_the_machines_clock(self) -> None:
        """Here the motor is the judge's own, which a busy machine makes late."""
        words = ("--real-time", "--only", "ramp", self.script_of("flaw_time_time.py"))
        judge = self.start("judge", *words)
        said = {0: "passed: all 2 figures of 1 scenario", 125: "this machine is too busy"}
        self.assertTrue(judge.logged(said.get(judge.wait(), "?")), judge.logged())


if __name__ == "__main__":
    # A program started in the background may ignore these, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    rospy.init_node("test_real_plant")
    rosrun("pid_control", "real_plant", RealPlant)
