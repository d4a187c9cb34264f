#!/usr/bin/env python3
"""Tests of the judge with a real plant: errors, and stopping the motor."""

import pathlib
import signal
import tempfile

import rospy
from helpers.real_plant_rig import ATTEMPTS, RealPlantCase

from nodekit import init_node
from nodekit.testing.running import rosrun
from pid_control.msg import set_point


class RealPlant(RealPlantCase):
    """Rare types of ends are in test/extended."""

    def test_judge_ctrl_c_stops_real_motor(self) -> None:
        self.host_motor()
        judge = self.start_judge("--real-time", *self.controller)
        self.assertEqual(judge.interrupt(), 130)
        self.assertFalse(judge.logged("Traceback"))
        self.assert_left_alone()

    def test_controller_has_its_parameters_beside_a_real_plant(self) -> None:
        """Its launch file gives it no integral part."""
        self.host_motor()
        with tempfile.TemporaryDirectory() as folder:
            gains = pathlib.Path(folder) / "gains.yaml"
            gains.write_text("{kp: 0.05, ki: 0.0}\n")
            words = ["pid_control", "motor_control.launch", f"control_config:={gains}"]
            for _ in range(ATTEMPTS):
                judge = self.start("judge", "--real-plant", "--only", "steps", *words)
                if judge.wait() != 125:  # as of a machine that is too busy
                    break
            self.assertEqual(judge.wait(), 1, judge.logged())
        self.assertTrue(judge.logged("steps: steady error "), judge.logged())
        self.assert_left_alone()

    def test_judge_invalid_request_names_the_problem(self) -> None:
        plant = ("--real-plant", *self.controller)
        missing = f"no plant found: {self.space}/motor_output has no publisher"
        self.assert_refused(missing, *plant)
        self.host_motor()
        other = rospy.Publisher(self.space + "/set_point", set_point, queue_size=1)
        self.addCleanup(other.unregister)
        rival = rospy.get_name()
        self.assert_refused(
            f"{self.space}/set_point: published by another node ({rival}); stop it first", *plant
        )
        self.assertEqual(self.inputs.messages(), [])


if __name__ == "__main__":
    # A program started in the background may ignore these, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    RealPlant.node = init_node("test_real_plant")
    RealPlant.node.start()
    rosrun("pid_control", "real_plant", RealPlant)
