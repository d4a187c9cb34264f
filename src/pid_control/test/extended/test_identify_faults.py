#!/usr/bin/env python3
"""Tests of rare faults of identify and tune: a silent motor, a missing field, Ctrl-C."""

import os
import pathlib
import signal

import rospy
from helpers.identify_rig import IdentifyCase

from nodekit import init_node
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from pid_control.msg import motor_input
from pid_control.recording.fields import FieldError
from pid_control.recording.live_experiment import DriveError, DriveSettings, LiveExperiment


class IdentifyFaults(IdentifyCase):
    """The commands run as separate processes."""

    def assert_refused(self, error: type, why: str, **fields: str) -> None:
        """Try to drive the motor in this process, which must be refused."""
        drive = DriveSettings("motor_input/input", "motor_output/output", 0.0, 1.0, 10.0)
        drive = drive._replace(**fields)
        with self.assertRaisesRegex(error, why):
            self.node.host(
                "identify", self.space, lambda node: LiveExperiment(node, drive, self.fail)
            )
        self.assertEqual(self.inputs.messages(), [])

    def test_tune_ctrl_c_exits_with_130(self) -> None:
        model = self.file("model.yaml")
        os.mkfifo(model)
        command = self.start("tune", model, "--gains", self.file("gains.yaml"))
        with open(model, "w"):
            # Ctrl-C just before it begins to wait for the content would be noticed with that only.
            state = pathlib.Path(f"/proc/{command.popen.pid}/stat")
            wait_until(
                lambda: state.read_text().rpartition(")")[2].split()[0] == "S", state.read_text
            )
            self.assertEqual(command.interrupt(), 130)
        self.assertFalse(command.logged("Traceback"))
        self.assertEqual(os.listdir(self.folder), ["model.yaml"])

    def test_silent_motor_ends_the_command(self) -> None:
        motor = self.host_motor()
        command = self.start("identify", "--seconds", "60")
        self.inputs.wait_for(lambda heard: heard.input > 0.0)
        motor.close()
        self.assertEqual(command.wait(), 1)
        self.assertTrue(command.logged("nothing on", "motor_output for 3 s"))
        self.wait_for_last_input()

    def test_identify_field_that_is_not_a_number_sets_the_exit_status(self) -> None:
        self.host_motor()
        command = self.start("identify", "--output", "motor_output/status")
        self.assertEqual(command.wait(), 2)
        why = "motor_output/status is not a number"
        self.assertTrue(command.logged(why), command.logged())
        self.assertFalse(command.logged("Traceback"))
        self.assertEqual(self.inputs.messages(), [])

    def test_identify_ctrl_c_stops_the_motor_with_an_error_status(self) -> None:
        self.host_motor()
        command = self.start("identify", "--seconds", "30", "--model", self.file("model.yaml"))
        self.inputs.wait_for(lambda heard: heard.input > 0.05)
        self.assertEqual(command.interrupt(), 1)
        self.assertTrue(command.logged("ended before the record was complete"))
        self.assert_stopped()
        self.assertEqual(os.listdir(self.folder), [])

    def test_identify_driven_or_unknown_motor_is_not_driven(self) -> None:
        self.host_motor()
        none = "speed/data: unknown topic"
        self.assert_refused(FieldError, none, output_name="speed/data")
        missing = "unknown field 'speed'; it has: output, time"
        self.assert_refused(FieldError, missing, output_name="motor_output/speed")
        missing = "unknown field 'speed'; it has: input, time"
        self.assert_refused(FieldError, missing, input_name="motor_input/speed")
        other = rospy.Publisher(self.space + "/motor_input", motor_input, queue_size=1)
        wait_until(other.get_num_connections, lambda: "the motor is not connected")
        drives = rf"driven by another node \({rospy.get_name()}\); stop it first"
        self.assert_refused(DriveError, drives)
        # The command reports it, with the status of an error in the command.
        command = self.start("identify")
        self.assertEqual(command.wait(), 2)
        self.assertTrue(
            command.logged(
                "identify: ", "driven by another node (/test_identify_faults); stop it first"
            )
        )
        self.assertFalse(command.logged("Traceback"))
        self.assertEqual(self.inputs.messages(), [])
        other.unregister()


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    IdentifyFaults.node = init_node("test_identify_faults")
    IdentifyFaults.node.start()
    rosrun("pid_control", "identify_faults", IdentifyFaults)
