#!/usr/bin/env python3
"""A generator whose rate is above that of /clock, which then stops."""

import unittest
from typing import List

import rospy
from rosgraph_msgs.msg import Clock
from roslib.packages import find_node

from basic_comms.msg import signal_msg
from nodekit.testing.graph import Graph
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until


class OnSlowClock(unittest.TestCase):
    """The test itself publishes /clock."""

    def setUp(self) -> None:
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.addCleanup(self.clock.unregister)

    def test_generator_on_a_clock_slower_than_its_rate_that_then_stands_still(self) -> None:
        rospy.set_param("/generator/rate", 1000.0)
        samples: List[float] = []
        subscriber = rospy.Subscriber(
            "/signal", signal_msg, lambda message: samples.append(message.time_x)
        )
        self.addCleanup(subscriber.unregister)
        generator = Process(
            find_node("basic_comms", "signal_generator.py")[0], ["__name:=generator"]
        )
        self.addCleanup(generator.end)
        graph = Graph()
        wait_until(
            lambda: "/generator" in graph.publishers("/signal"),
            lambda: f"start: {generator.logged()}",
        )
        graph.wait_until_heard("/generator", "/signal", rospy.get_name())
        graph.wait_until_heard(rospy.get_name(), "/clock", "/generator")
        for number in range(5):
            self.clock.publish(Clock(rospy.Time.from_sec(200.0 + number / 10)))
            wait_until(lambda: len(samples) > number, lambda: str(samples))
        steps = [later - earlier for earlier, later in zip(samples, samples[1:])]
        self.assertEqual([round(step, 6) for step in steps], [0.1] * 4)
        self.assertEqual(generator.interrupt(), 0)
        self.assertEqual(generator.logged("Traceback"), [])


if __name__ == "__main__":
    rospy.init_node("test_slow_clock")
    rosrun("basic_comms", "slow_clock", OnSlowClock)
