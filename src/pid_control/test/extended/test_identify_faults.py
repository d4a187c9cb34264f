#!/usr/bin/env python3
"""Tests of rare faults of identify and tune: a silent motor, a missing field."""

import os
import signal

from helpers.identify_rig import IdentifyCase

from nodekit import init_node
from nodekit.testing.running import rosrun


class IdentifyFaults(IdentifyCase):
    """The commands are processes of their own."""

    def test_tune_ctrl_c_exits_with_130(self) -> None:
        model = self.file("model.yaml")
        os.mkfifo(model)
        command = self.start("tune", model, "--gains", self.file("gains.yaml"))
        with open(model, "w"):  # from here on it waits for what is in it
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

    def test_identify_unknown_names_set_the_exit_status(self) -> None:
        self.host_motor()
        for arguments, why, status in (
            (["--output", "speed/data"], "speed/data: unknown topic", 2),
            (["--output", "motor_output/speed"], "unknown field 'speed'; it has: output, time", 2),
            (["--output", "motor_output/status"], "motor_output/status is not a number", 2),
            (["--input", "motor_input/speed"], "unknown field 'speed'; it has: input, time", 2),
        ):
            command = self.start("identify", *arguments)
            self.assertEqual(command.wait(), status, why)
            self.assertTrue(command.logged(why), (why, command.logged()))
            self.assertFalse(command.logged("Traceback"))
            self.assertEqual(self.inputs.messages(), [])


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    IdentifyFaults.node = init_node("test_identify_faults")
    IdentifyFaults.node.start()
    rosrun("pid_control", "identify_faults", IdentifyFaults)
