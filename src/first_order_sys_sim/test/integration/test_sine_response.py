#!/usr/bin/env python3
"""The sine response on the topics against the analytic solution, sample by sample."""

import math
import unittest
from typing import List
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float32

from nodekit import to_float32
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

GAIN, TAU, SAMPLE_TIME, RATE = 13.2, 0.05, 0.02, 150.0
AMPLITUDE, OMEGA = 0.5, 2.0
NODE = "/first_order_sys"
#: Rounding of a float32 of a magnitude below 8.
ROUNDING = 2.0**-22


def sine(time: float) -> float:
    """Return the input as a message carries it."""
    return to_float32(AMPLITUDE * math.sin(OMEGA * time))


def analytic(time: float) -> float:
    """Return the response from rest to the sine itself, never sampled."""
    ratio = OMEGA * TAU
    swing = math.sin(OMEGA * time) - ratio * math.cos(OMEGA * time)
    return GAIN * AMPLITUDE / (1.0 + ratio**2) * (swing + ratio * math.exp(-time / TAU))


class SineResponse(unittest.TestCase):
    """A system whose time the test controls."""

    def setUp(self) -> None:
        rospy.init_node("test_sine_response")
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.input = rospy.Publisher("input", Float32, queue_size=10)
        self.output = MessageRecorder("output", Float32)
        self.sent = 0
        wait_until(lambda: self.input.get_num_connections(), lambda: "the node does not listen")
        graph = Graph()
        graph.wait_until_heard(rospy.get_name(), "/clock", NODE)
        graph.wait_until_heard(NODE, "/output", rospy.get_name())
        self.node = ServerProxy(rosgraph.Master("/test").lookupNode(NODE))

    def received(self, topic: str) -> int:
        """Return how many messages the node has received on a topic."""
        subscriptions = self.node.getBusStats("/test")[2][1]
        return sum(link[2] for name, links in subscriptions if name == topic for link in links)

    def output_at(self, number: int) -> float:
        """Move the clock to when output ``number`` is due, and return it."""
        # Later by a hair, as the clock's nanoseconds must not round to before.
        time = rospy.Time.from_sec(1.0 + number / RATE + (1e-6 if number else 0.0))
        self.clock.publish(Clock(time))
        wait_until(
            lambda: len(self.output.messages()) > number,
            lambda: f"no output {number}",
        )
        return float(self.output.messages()[number].data)

    def send(self, value: float) -> None:
        """Send an input, and wait until the node has received it."""
        self.sent += 1
        self.input.publish(Float32(value))
        wait_until(
            lambda: self.received("/input") == self.sent,
            lambda: "the input did not arrive",
        )

    def record(self, count: int) -> List[float]:
        """Return the outputs, with the sine as the input of each sample."""
        outputs = []
        for number in range(count):
            outputs.append(self.output_at(number))
            if number % 3 == 0:  # three outputs a sample
                self.send(sine(number / RATE))
        return outputs

    def test_response_is_that_to_the_held_sine_and_near_that_to_the_sine(self) -> None:
        held, state, begun = 0.0, 0.0, 0.0
        # Held for a sample time, the input is off by at most AMPLITUDE OMEGA SAMPLE_TIME: the
        # steepest slope of the sine times the oldest age. The plant's impulse response is positive
        # and its integral is GAIN, so the output is off by no more than GAIN times that.
        bound = GAIN * AMPLITUDE * OMEGA * SAMPLE_TIME
        worst = 0.0
        for number, output in enumerate(self.record(480)):
            time = number / RATE
            expected = GAIN * held + (state - GAIN * held) * math.exp(-(time - begun) / TAU)
            self.assertAlmostEqual(output, expected, delta=ROUNDING, msg=f"output {number}")
            worst = max(worst, abs(output - analytic(time)))
            if number % 3 == 0:
                held, state, begun = sine(time), expected, time
        self.assertLess(worst, bound + ROUNDING)


if __name__ == "__main__":
    rosrun("first_order_sys_sim", "sine_response", SineResponse)
