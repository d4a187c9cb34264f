#!/usr/bin/env python3
"""The motor on the wire: its response, its parameters, and its service."""

import math
import unittest
from typing import List

import rosgraph
import rospy
from helpers.putting_back import wait_for_put_backs
from rosgraph_msgs.msg import Log
from roslib.packages import find_node
from std_msgs.msg import Float32, String

from motor_control_msgs.srv import SetProcessBool
from nodekit.testing.changing import change
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

GAIN, TAU, SAMPLE_TIME = 1.75, 0.05, 0.02
#: Sample time for responses: a busy machine does not skip all samples of it [s].
SLOW_TAU = 0.2
#: Rounding of a float32 of a magnitude from 2 to 4.
ROUNDING = 2.0**-23
NODE = "/lab/motor_sys"


class DcMotor(unittest.TestCase):
    """A motor that has just been enabled before each test."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_dc_motor")
        cls.input = rospy.Publisher("/lab/motor_input_u", Float32, queue_size=10)
        cls.speed = MessageRecorder("/lab/motor_speed_y", Float32)
        cls.state = MessageRecorder("/lab/motor_state", String)
        cls.log = MessageRecorder("/rosout", Log)
        rospy.wait_for_service("/lab/EnableProcess", TIMEOUT_S)
        cls.enable = rospy.ServiceProxy("/lab/EnableProcess", SetProcessBool)
        wait_until(cls.input.get_num_connections, lambda: "the motor has not subscribed")
        # In the state in which it starts, the motor is silent.
        cls.state.wait_for(lambda state: state.data == "waiting")
        assert not cls.speed.messages()

    def setUp(self) -> None:
        self.state.clear()
        self.enable(False)
        self.speed.clear()
        self.log.clear()
        self.assertEqual(self.enable(True).message, "enabled")
        self.state.wait_for(lambda state: state.data == "enabled")

    def slow_down(self) -> None:
        """Use a longer time constant in this test."""
        change(NODE, sys_tau_T=SLOW_TAU)
        self.addCleanup(change, NODE, sys_tau_T=TAU)

    def values(self) -> List[float]:
        return [heard.data for heard in self.speed.messages()]

    def settle(self, target: float) -> List[float]:
        """Wait for a steady speed, and return all heard."""
        wait_until(
            lambda: self.values() and abs(self.values()[-1] - target) < 1e-6,
            lambda: f"the speed is {self.values()[-1:]}, not {target}",
        )
        return self.values()

    def assert_response(self, values: List[float], target: float) -> None:
        """Compare speeds with the response from the first of them to a target.

        The motor samples its input when it publishes, so the analytic solution holds from sample to
        sample; but a busy machine may skip samples, and they have no stamp. So each speed is
        compared with the value of the nearest sample.
        """
        start, last = values[0], 0
        for value in values[1:]:
            # Nearer to the target the rounding would hide which sample it is.
            if abs(value - target) < 0.01 * abs(start - target):
                break
            gone = SLOW_TAU * math.log((start - target) / (value - target))
            sample = round(gone / SAMPLE_TIME)
            exact = target + (start - target) * math.exp(-sample * SAMPLE_TIME / SLOW_TAU)
            self.assertAlmostEqual(value, exact, delta=2.0 * ROUNDING, msg=f"sample {sample}")
            self.assertGreater(sample, last)
            last = sample
        self.assertGreater(last, 8)

    def test_step_response_is_exact_to_the_last_bits_of_float32(self) -> None:
        self.slow_down()
        self.input.publish(Float32(2.0))
        values = self.settle(3.5)
        rest = max(index for index, value in enumerate(values) if value == 0.0)
        self.assert_response(values[rest:], 3.5)

    def test_change_of_gain_makes_no_jump_and_is_logged(self) -> None:
        self.slow_down()
        self.addCleanup(change, NODE, sys_gain_K=GAIN)
        self.input.publish(Float32(0.5))
        self.settle(0.875)
        rospy.set_param(NODE + "/sys_gain_K", 8.0)
        values = self.settle(4.0)
        # It takes effect at a sample.
        before = max(index for index, value in enumerate(values) if abs(value - 0.875) < 1e-6)
        self.assert_response(values[before:], 4.0)
        self.log.wait_for(lambda line: NODE + "/sys_gain_K: 1.75 -> 8" in line.msg)

    def test_change_of_sample_time_makes_no_jump(self) -> None:
        self.slow_down()
        self.addCleanup(change, NODE, sample_time=SAMPLE_TIME)
        change(NODE, sample_time=0.001)
        self.input.publish(Float32(2.0))
        values = self.settle(3.5)
        rising = [value for value in values if 0.0 < value < 3.0]
        steps = [
            SLOW_TAU * math.log((3.5 - before) / (3.5 - after))
            for before, after in zip(rising, rising[1:])
        ]
        # A busy machine may leave samples out, but all of them belong to whole milliseconds.
        for step in steps:
            self.assertGreater(step, 0.0)
            self.assertAlmostEqual(step, round(step, 3), delta=1e-6)
        self.assertAlmostEqual(min(steps), 0.001, delta=1e-6)

    def test_negative_gain_and_time_constant_are_refused_with_the_reason(self) -> None:
        for name, kept, reason in (
            ("sys_gain_K", GAIN, "a number in [0, 1e6]; in force is sys_gain_K=1.75"),
            ("sys_tau_T", TAU, "a number in (0, 1e6] (s); in force is sys_tau_T=0.05"),
        ):
            rospy.set_param(f"{NODE}/{name}", -1.0)
            line = self.log.wait_for(lambda line: name in line.msg)
            self.assertEqual(line.level, Log.WARN)
            text = f"parameter {NODE}/{name}: refused -1: must be {reason}"
            self.assertEqual(line.msg, text)
            wait_until(
                lambda: rospy.get_param(f"{NODE}/{name}") == kept,
                lambda: f"{name} is not put back",
            )

    def test_initial_conditions_are_where_it_starts_and_can_be_set_live(self) -> None:
        self.addCleanup(rospy.set_param, NODE + "/initial_conditions", 0.0)
        rospy.set_param(NODE + "/initial_conditions", -1.5)
        self.speed.wait_for(lambda heard: heard.data == -1.5)
        self.speed.wait_for(lambda heard: -1.5 < heard.data < 0.0)  # from where it goes on
        self.enable(False)
        wait_until(lambda: self.values()[-1] == 0.0, lambda: "it does not stop")
        self.speed.clear()
        self.enable(True)
        self.speed.wait_for(lambda heard: True)
        self.assertEqual(self.values()[0], -1.5)

    def test_disabled_it_stands_still_and_is_silent(self) -> None:
        self.input.publish(Float32(2.0))
        self.settle(3.5)
        self.state.clear()
        answer = self.enable(False)
        self.assertEqual((answer.success, answer.message), (True, "disabled"))
        self.state.wait_for(lambda state: state.data == "disabled")
        wait_until(lambda: self.values()[-1] == 0.0, lambda: "it does not stop")
        self.speed.clear()
        answer = self.enable(False)
        self.assertEqual((answer.success, answer.message), (True, "disabled already"))
        wait_for_put_backs(NODE, 10)
        self.assertEqual(self.values(), [])
        self.assertEqual([state.data for state in self.state.messages()], ["disabled"])
        # Its former input has no effect now.
        self.enable(True)
        wait_until(lambda: len(self.values()) > 10, lambda: "it does not go on")
        self.assertEqual(set(self.values()), {0.0})

    def test_second_enable_changes_nothing(self) -> None:
        self.input.publish(Float32(2.0))
        self.settle(3.5)
        self.speed.clear()
        answer = self.enable(True)
        self.assertEqual((answer.success, answer.message), (True, "enabled already"))
        wait_until(lambda: len(self.values()) > 5, lambda: "it does not go on")
        self.assertTrue(all(abs(value - 3.5) < 1e-5 for value in self.values()))

    def test_input_that_is_not_finite_is_left_out_with_a_warning(self) -> None:
        self.input.publish(Float32(2.0))
        self.input.publish(Float32(math.inf))
        line = self.log.wait_for(lambda line: "not finite" in line.msg)
        self.assertEqual(line.level, Log.WARN)
        self.settle(3.5)

    def test_second_motor_in_one_namespace_leaves_the_first_one_its_service(self) -> None:
        master = rosgraph.Master("/test")
        name = "/lab/EnableProcess"
        own = master.lookupService(name)
        other = Process(find_node("motor_control", "dc_motor.py")[0], ["__ns:=lab"])
        self.addCleanup(other.end)
        other.wait_for_log("WARN", "already offered", name + f" ({NODE})")
        wait_until(lambda: master.lookupService(name) != own, lambda: "it is not taken over")
        self.log.wait_for(
            lambda log: (
                log.name == NODE
                and "taken over" in log.msg
                and name + " (/lab/dc_motor)" in log.msg
            )
        )
        self.assertEqual(other.interrupt(), 0)
        self.log.wait_for(lambda log: log.name == NODE and "registered again" in log.msg)
        self.assertEqual(master.lookupService(name), own)
        self.assertEqual(self.enable(True).message, "enabled already")


if __name__ == "__main__":
    rosrun("motor_control", "dc_motor", DcMotor)
