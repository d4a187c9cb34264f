#!/usr/bin/env python3
"""The first-order system on the wire, in a namespace, and behind the nodes of basic_comms."""

import math
import unittest
from typing import List

import rospy
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float32

from nodekit.testing.changing import change
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

TAU, RATE = 0.05, 150.0
#: Rounding of a float32 of a magnitude from 4 to 8, and from 8 to 16.
ROUNDING, COARSE_ROUNDING = 2.0**-22, 2.0**-21
NODE = "/lab/first_order_sys"


class FirstOrderSys(unittest.TestCase):
    """The system with the course's values, at rest before each test."""

    input: rospy.Publisher
    output: MessageRecorder
    log: MessageRecorder

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_first_order_sys")
        cls.input = rospy.Publisher("/lab/input", Float32, queue_size=10)
        cls.output = MessageRecorder("/lab/output", Float32)
        cls.log = MessageRecorder("/rosout", Log)
        wait_until(cls.input.get_num_connections, lambda: "no node subscribes to /lab/input")

    def setUp(self) -> None:
        self.send(0.0)
        # On its own it would take 5 s to decay to 0 in float32.
        almost_zero = 1e-300 if rospy.get_param(NODE + "/system_initial_conditions") == 0.0 else 0.0
        change(NODE, system_param_K=13.2, system_initial_conditions=almost_zero)
        self.log.clear()
        self.output.clear()
        wait_until(self.rests, lambda: f"the output is {self.latest()}")

    def send(self, value: float) -> None:
        self.input.publish(Float32(value))

    def latest(self) -> float:
        """Return the latest output, NaN before the first."""
        heard = self.output.messages()
        return float(heard[-1].data) if heard else math.nan

    def rests(self) -> bool:
        """Return whether the output has been 0 for longer than a sample time."""
        heard = [message.data for message in self.output.messages()][-10:]
        return len(heard) == 10 and not any(heard)

    def settle(self, value: float) -> List[float]:
        """Wait for a steady output, and return all since those of rest."""
        wait_until(
            lambda: abs(self.latest() - value) < 1e-6,
            lambda: f"the output is {self.latest()}, not {value}",
        )
        return [heard.data for heard in self.output.messages()]

    def assert_response(self, values: List[float], target: float, rounding: float) -> None:
        """Compare outputs with the response from the first of them to a target.

        Outputs are published every 1 / RATE, but a busy machine may skip some, and they have no
        stamp. So each is compared with the value of the nearest period.
        """
        start, last = values[0], 0
        for value in values[1:]:
            # Nearer to the target the rounding would hide which period it is.
            if abs(value - target) < 0.01 * abs(start - target):
                break
            period = round(-TAU * RATE * math.log((value - target) / (start - target)))
            exact = target + (start - target) * math.exp(-period / RATE / TAU)
            # The start is rounded too.
            self.assertAlmostEqual(value, exact, delta=2.0 * rounding, msg=f"period {period}")
            self.assertGreater(period, last)
            last = period
        self.assertGreater(last, 20)

    def test_step_response_is_exact_to_the_last_bit_of_float32(self) -> None:
        self.send(0.5)
        values = self.settle(6.6)
        # A sample lies on an output, as 0.02 s are three periods of 150 Hz: the last output of rest
        # is at the very moment at which the step was sampled, but for the rounding of times.
        rest = max(index for index, value in enumerate(values) if abs(value) < 1e-9)
        self.assert_response(values[rest:], 6.6, ROUNDING)

    def test_output_stops_at_its_limit_and_leaves_it_at_once(self) -> None:
        self.send(50.0)
        values = self.settle(13.0)
        self.assertEqual(max(values), 13.0)
        # Wound up, the state would need ln(660 / 13) tau = 0.2 s to come back: 30 outputs.
        self.send(0.5)
        values = self.settle(6.6)
        held = max(index for index, value in enumerate(values) if value == 13.0)
        self.assert_response(values[held:], 6.6, COARSE_ROUNDING)

    def test_input_in_the_dead_zone_acts_as_zero(self) -> None:
        self.output.clear()
        self.send(0.2)
        self.send(-0.2)
        self.send(0.2)
        wait_until(lambda: len(self.output.messages()) > 30, lambda: "no output")
        self.assertEqual({heard.data for heard in self.output.messages()}, {0.0})
        self.send(-0.25)
        self.settle(-3.3)

    def test_change_of_gain_makes_no_jump(self) -> None:
        self.send(0.5)
        self.settle(6.6)
        self.output.clear()
        rospy.set_param(NODE + "/system_param_K", 26.0)
        values = self.settle(13.0)
        # The change is between two outputs, so the next one is within a period of the former y.
        first = next(index for index, value in enumerate(values) if value > 6.61)
        self.assert_response(values[first:], 13.0, COARSE_ROUNDING)
        self.log.wait_for(lambda line: "system_param_K: 13.2 -> 26" in line.msg)

    def test_time_constant_below_zero_is_refused_with_the_reason(self) -> None:
        rospy.set_param(NODE + "/system_param_T", -0.05)
        line = self.log.wait_for(lambda line: "system_param_T" in line.msg)
        self.assertEqual(line.level, Log.WARN)
        self.assertIn(NODE + "/system_param_T: refused -0.05: must be a number", line.msg)
        wait_until(
            lambda: rospy.get_param(NODE + "/system_param_T") == 0.05,
            lambda: f"{rospy.get_param(NODE + '/system_param_T')} is not put back",
        )
        self.send(0.5)
        self.settle(6.6)

    def test_change_of_initial_conditions_puts_the_output_there(self) -> None:
        rospy.set_param(NODE + "/system_initial_conditions", -5.0)
        self.output.wait_for(lambda heard: -5.0 <= heard.data < -5.0 * math.exp(-1.0 / RATE / TAU))

    def test_input_that_is_not_finite_is_left_out_with_a_warning(self) -> None:
        self.send(0.5)
        self.send(math.nan)
        line = self.log.wait_for(lambda line: "not finite" in line.msg)
        self.assertEqual(line.level, Log.WARN)
        self.settle(6.6)

    def test_it_works_behind_process_by_a_remap(self) -> None:
        output = MessageRecorder("/output", Float32)
        # proc_signal swings from 0 to 2, which takes the output from 0 to its limit and back.
        output.wait_for(lambda heard: heard.data == 13.0)
        output.clear()
        output.wait_for(lambda heard: heard.data < 1.0)
        output.close()


if __name__ == "__main__":
    rosrun("first_order_sys_sim", "first_order_sys", FirstOrderSys)
