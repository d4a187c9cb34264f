#!/usr/bin/env python3
"""Tests of rare ends of the judge with a real plant: it stops the motor."""

import os
import pathlib
import signal
import tempfile

from helpers.real_plant_rig import ATTEMPTS, RealPlantCase

from nodekit import init_node
from nodekit.testing.graph import Graph
from nodekit.testing.processes import free_port
from nodekit.testing.running import rosrun

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


class RealPlantFaults(RealPlantCase):
    """Each test has a namespace, in which it judges."""

    def test_judge_closed_terminal_stops_real_motor(self) -> None:
        self.host_motor()
        judge = self.start_judge(*self.controller)
        judge.popen.send_signal(signal.SIGHUP)
        self.assertEqual(judge.wait(), 128 + signal.SIGHUP)
        self.assert_left_alone()

    def test_judge_node_shutdown_stops_real_motor(self) -> None:
        self.host_motor()
        judge = self.start_judge(*self.controller)
        Graph().kill(self.space + "/judge")
        self.assertEqual(judge.wait(), 125)
        self.assertTrue(judge.logged("not judged: the node was shut down"), judge.logged())
        self.assert_stopped()

    def test_controller_that_ignores_ctrl_c_is_killed_at_the_second_too(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "stubborn.py"
            script.write_text(STUBBORN.format(folder=os.path.dirname(self.controller[0])))
            script.chmod(0o755)
            self.host_motor()
            judge = self.start_judge(str(script), *self.remappings)
            self.wanted.clear()
            judge.popen.send_signal(signal.SIGINT)
            # The judge asks for no speed, and waits for the controller.
            self.wanted.wait_for(lambda heard: heard.setPoint == 0.0)
            self.assertEqual(judge.interrupt(), 130)
        self.assert_stopped()

    def test_silent_motor_ends_the_command(self) -> None:
        motor = self.host_motor()
        judge = self.start_judge(*self.controller)
        motor.close()
        self.assertEqual(judge.wait(), 125)
        self.assertTrue(judge.logged("the plant is silent: nothing on", "motor_output for 0.8 s"))
        self.wait_for_last_input()

    def test_real_plant_needs_a_master(self) -> None:
        no_master = f"http://localhost:{free_port()}"
        words = ("--real-plant", *self.controller)
        self.assert_refused("needs your own master", *words, ROS_MASTER_URI=no_master)

    def test_judge_real_time_accepts_machine_clock(self) -> None:
        """Here the motor is the judge's own; a busy machine makes it, or the controller, late."""
        words = ("--real-time", "--only", "ramp", self.script_of("flaw_time_time.py"))
        said = {0: "passed: all 2 figures of 1 scenario", 125: "this machine is too busy"}
        for _ in range(ATTEMPTS):
            judge = self.start("judge", *words)
            if judge.logged(said.get(judge.wait(), "?")):
                return
        self.fail(str(judge.logged()))


if __name__ == "__main__":
    # A program started in the background may ignore these, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    RealPlantFaults.node = init_node("test_real_plant_faults")
    RealPlantFaults.node.start()
    rosrun("pid_control", "real_plant_faults", RealPlantFaults)
