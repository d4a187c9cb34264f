#!/usr/bin/env python3
"""A running motor is identified, and a recorded one, and the motor is stopped whatever happens."""

import os
import shutil
import tempfile
import unittest

import rosbag
import rospkg
import rospy
from std_msgs.msg import String

from nodekit.testing.hearing import Ear
from nodekit.testing.launching import launched
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from pid_control.msg import motor_input, motor_output

SCRIPTS = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts")
#: A motor, the model beside it, and a controller with the gains that were found for it.
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
    <param name="set_point_generator/waveform" value="constant"/>
    <param name="set_point_generator/amplitude" value="0.0"/>
    <param name="set_point_generator/offset" value="4.0"/>
  </group>
</launch>
"""


class Identify(unittest.TestCase):
    """Each test has a namespace, and a folder for what is written."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.inputs = Ear(self.space + "/motor_input", motor_input)
        self.outputs = Ear(self.space + "/motor_output", motor_output)

    def start(self, name: str, *arguments: str) -> Process:
        process = Process(os.path.join(SCRIPTS, name), ["__ns:=" + self.space, *arguments])
        self.addCleanup(process.end)
        return process

    def start_motor(self, *arguments: str) -> Process:
        motor = self.start("system.py", *arguments)
        self.outputs.wait_for(lambda heard: True)
        return motor

    def file(self, name: str) -> str:
        return os.path.join(self.folder, name)

    def assert_stopped(self) -> None:
        """Wait until the motor stands, with 0 the last input."""
        self.outputs.forget()
        self.outputs.wait_for(lambda heard: heard.status == "Motor Not Turning")
        self.wait_for_last_input()

    def wait_for_last_input(self) -> None:
        """Wait until the last input is 0."""
        wait_until(
            lambda: self.inputs.messages()[-1].input == 0.0,
            lambda: f"the last input is {self.inputs.messages()[-1]}",
        )

    def test_model_that_was_found_moves_as_the_motor_and_its_gains_control_it(self) -> None:
        """Course 003-pid-7, 003-pid-8."""
        model, gains = self.file("model.yaml"), self.file("gains.yaml")
        with open(model, "w") as file:
            file.write("system_param_K: 10.0\nsystem_param_T: 0.2\nsystem_dead_time: 0.05\n")
        tuned = self.start("tune", model, "--gains", gains, "--picture", self.file("steps.svg"))
        self.assertEqual(tuned.wait(), 0, tuned.logged())
        self.assertEqual(len(tuned.logged("ziegler-nichols")), 2)
        with open(self.file("loop.launch"), "w") as file:
            file.write(LAUNCH.format(space=self.space, model=model, gains=gains))
        modelled = Ear(self.space + "/model_output", motor_output)
        with launched(self.file("loop.launch")):
            for outputs in (self.outputs, modelled):
                outputs.wait_for(lambda heard: abs(heard.output - 4.0) < 0.1 and heard.time > 2.0)
        modelled.close()

    def test_gains_of_no_model_are_refused(self) -> None:
        bad = self.file("bad.yaml")
        with open(bad, "w") as file:
            file.write("system_param_K: 10.0\n")
        for arguments, why in (
            ([bad], "bad.yaml: system_param_T is missing"),
            ([self.file("none.yaml")], "none.yaml: No such file or directory"),
            ([bad, "--period", "0"], "'0' must be from 0.0001 to 1000 s"),
            ([bad, "--method", "guess"], "invalid choice: 'guess'"),
            ([bad, "--least", "1"], "--least must be at most 0"),
        ):
            command = self.start("tune", *arguments, "--gains", self.file("gains.yaml"))
            self.assertEqual(command.wait(), 2)
            self.assertTrue(command.logged(why), (why, command.logged()))
            self.assertFalse(command.logged("Traceback"))
        self.assertEqual(os.listdir(self.folder), ["bad.yaml"])

    def test_ctrl_c_ends_tuning_as_a_shell_puts_it(self) -> None:
        model = self.file("model.yaml")
        os.mkfifo(model)
        command = self.start("tune", model, "--gains", self.file("gains.yaml"))
        with open(model, "w"):  # from here on it waits for what is in it
            self.assertEqual(command.interrupt(), 130)
        self.assertFalse(command.logged("Traceback"))
        self.assertEqual(os.listdir(self.folder), ["model.yaml"])

    def test_ctrl_c_stops_the_motor_and_is_no_success(self) -> None:
        self.start_motor()
        command = self.start("identify", "--seconds", "30", "--model", self.file("model.yaml"))
        self.inputs.wait_for(lambda heard: heard.input > 0.05)
        self.assertEqual(command.interrupt(), 1)
        self.assertTrue(command.logged("ended before the record was complete"))
        self.assert_stopped()
        self.assertFalse(os.path.exists(self.file("model.yaml")))

    def test_motor_that_falls_silent_is_given_up(self) -> None:
        motor = self.start_motor()
        command = self.start("identify", "--seconds", "60")
        self.inputs.wait_for(lambda heard: heard.input > 0.0)
        motor.end()
        self.assertEqual(command.wait(), 1)
        self.assertTrue(command.logged("nothing on", "motor_output for 3 s"))
        self.wait_for_last_input()

    def test_motor_that_somebody_else_drives_is_left_alone(self) -> None:
        self.start_motor()
        other = rospy.Publisher(self.space + "/motor_input", motor_input, queue_size=1)
        wait_until(lambda: other.get_num_connections() == 2, lambda: "no connections")
        command = self.start("identify")
        self.assertEqual(command.wait(), 2)
        self.assertTrue(command.logged("/test_identify drives", "end that first"))
        self.assertEqual(self.inputs.messages(), [])
        other.unregister()

    def test_topic_and_bounds_that_are_wrong_are_refused_by_name(self) -> None:
        self.start_motor()
        for arguments, why, status in (
            (["--output", "speed/data"], "speed/data: there is no such topic", 2),
            (["--output", "motor_output/speed"], "there is no 'speed'; it has: output, time", 1),
            (["--input", "motor_input/speed"], "there is no 'speed'; it has: input, time", 2),
            ([self.file("none.bag")], "No such file or directory", 2),
            (["--largest", "0"], "--largest above it", 2),
            (["--least", "nan"], "'nan' is not a finite number", 2),
            (["--seconds", "0"], "'0' must be from 1 to 3600 s", 2),
            (["--model", self.file("no/m.yaml")], "no/m.yaml: No such file or directory", 2),
            (["--picture", self.file("no/p.svg")], "no/p.svg: No such file or directory", 2),
            (["--model", "m.txt"], "'m.txt' does not end in .yaml or .yml", 2),
        ):
            command = self.start("identify", *arguments)
            self.assertEqual(command.wait(), status, why)
            self.assertTrue(command.logged(why), (why, command.logged()))
            self.assertFalse(command.logged("Traceback"))
            self.assertEqual(self.inputs.messages(), [])

    def test_bag_of_any_two_numbers_is_enough(self) -> None:
        path = self.file("run.bag")
        with rosbag.Bag(path, "w") as bag:
            for number in range(1000):
                time = rospy.Time.from_sec(100.0 + 0.01 * number)
                given = 0.5 if number >= 200 else 0.0
                speed = 0.0 if number < 200 else 4.0 * (1.0 - 0.98 ** (number - 200))
                if number in (100, 200):
                    bag.write("/a/given", motor_input(given, 0.0), time)
                bag.write("/a/done", motor_output(speed, 0.01 * number, ""), time)
            bag.write("/a/given", motor_input(0.0, 0.0), rospy.Time.from_sec(109.999))
            # What else is in it is not read: nothing could read this.
            broken = (String._type, b"", String._md5sum, String)
            bag.write("/a/other", broken, rospy.Time.from_sec(105.0), raw=True)
        fields = ["--input", "/a/given/input", "--output", "/a/done/output"]
        command = self.start("identify", path, *fields)
        self.assertEqual(command.wait(), 0, command.logged())
        (line,) = command.logged("K   ")
        self.assertAlmostEqual(float(line.split()[1]), 8.0, delta=0.01)
        silent = self.start("identify", path, *fields, "--end", "1.5")
        self.assertEqual(silent.wait(), 1)
        self.assertTrue(silent.logged("cannot tell: the input never changes: it is 0 throughout"))


if __name__ == "__main__":
    rospy.init_node("test_identify")
    rosrun("pid_control", "identify", Identify)
