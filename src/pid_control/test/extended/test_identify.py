#!/usr/bin/env python3
"""Tests of identify with a running motor, and of the loop with the gains of tune."""

import signal

from helpers.identify_rig import IdentifyCase

from nodekit import init_node
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.running import rosrun
from pid_control.msg import motor_output

#: A motor, the model beside it, and a controller with the gains found for it. Both motors
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


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    Identify.node = init_node("test_identify")
    Identify.node.start()
    rosrun("pid_control", "identify", Identify)
