#!/usr/bin/env python3
"""Tests of identify with a running motor, and of the loop with the gains of tune."""

import os
import signal

import rospy
from helpers.identify_rig import IdentifyCase

from nodekit import init_node
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from pid_control.msg import motor_input, motor_output
from pid_control.recording.fields import FieldError
from pid_control.recording.live_experiment import DriveError, DriveSettings, LiveExperiment

#: A motor, the model beside it, and a controller with the gains that were found for it. Both motors
#: have fewer outputs than the course's.
LAUNCH = """
<launch>
  <group ns="{space}">
    <include file="$(find pid_control)/launch/system.launch">
      <arg name="system_config" value="{model}"/>
    </include>
    <include file="$(find pid_control)/launch/model.launch">
      <arg name="model" value="{model}"/>
    </include>
    <include file="$(find pid_control)/launch/pid_real.launch">
      <arg name="control_config" value="{gains}"/>
    </include>
    <param name="system/system_node_rate" value="200.0"/>
    <param name="model/system_node_rate" value="200.0"/>
    <param name="set_point_generator/waveform" value="constant"/>
    <param name="set_point_generator/amplitude" value="0.0"/>
    <param name="set_point_generator/offset" value="4.0"/>
  </group>
</launch>
"""


class Identify(IdentifyCase):
    """Errors in arguments are in the unit tests, rare faults in test/extended."""

    def assert_refused(self, error: type, why: str, **fields: str) -> None:
        """Try to drive the motor in this process, which must be refused."""
        drive = DriveSettings("motor_input/input", "motor_output/output", 0.0, 1.0, 10.0)
        drive = drive._replace(**fields)
        with self.assertRaisesRegex(error, why):
            self.node.host(
                "identify", self.space, lambda node: LiveExperiment(node, drive, self.fail)
            )
        self.assertEqual(self.inputs.messages(), [])

    def test_identified_model_follows_the_motor_and_its_gains_control_it(self) -> None:
        """Course 003-pid-7, 003-pid-8."""
        model, gains = self.file("model.yaml"), self.file("gains.yaml")
        with open(model, "w") as file:
            file.write("system_param_K: 10.0\nsystem_param_T: 0.2\nsystem_dead_time: 0.05\n")
        tuned = self.start("tune", model, "--gains", gains, "--picture", self.file("steps.svg"))
        self.assertEqual(tuned.wait(), 0, tuned.logged())
        self.assertEqual(len(tuned.logged("ziegler-nichols")), 2)
        with open(self.file("loop.launch"), "w") as file:
            file.write(LAUNCH.format(space=self.space, model=model, gains=gains))
        modelled = MessageRecorder(self.space + "/model_output", motor_output)
        self.addCleanup(modelled.close)
        with launched(self.file("loop.launch")):
            for outputs in (self.outputs, modelled):
                outputs.wait_for(lambda heard: abs(heard.output - 4.0) < 0.1 and heard.time > 2.0)

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
        missing = "unknown field 'speed'; it has: input, time"
        self.assert_refused(FieldError, missing, input_name="motor_input/speed")
        other = rospy.Publisher(self.space + "/motor_input", motor_input, queue_size=1)
        wait_until(other.get_num_connections, lambda: "the motor is not connected")
        drives = rf"driven by another node \({rospy.get_name()}\); stop it first"
        self.assert_refused(DriveError, drives)
        # The command says so, and its status is that of something wrong with the command.
        command = self.start("identify")
        self.assertEqual(command.wait(), 2)
        self.assertTrue(
            command.logged("identify: ", "driven by another node (/test_identify); stop it first")
        )
        self.assertFalse(command.logged("Traceback"))
        self.assertEqual(self.inputs.messages(), [])
        other.unregister()


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    Identify.node = init_node("test_identify")
    Identify.node.start()
    rosrun("pid_control", "identify", Identify)
