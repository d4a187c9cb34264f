#!/usr/bin/env python3
"""Tests of an executor while /clock is paused: only timers wait."""

import unittest
from typing import List

import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerRequest

from nodekit import CallError, SingleThreadedExecutor
from nodekit.node.ros_node import Node
from nodekit.process.run import init_node
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class OnAClockThatStandsStill(unittest.TestCase):
    """The test itself publishes /clock."""

    def setUp(self) -> None:
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.addCleanup(self.clock.unregister)
        self.now = 100.0

    def step(self, seconds: float) -> None:
        self.now += seconds
        self.clock.publish(Clock(rospy.Time.from_sec(self.now)))

    def test_timers_tick_once_a_step_and_messages_are_received(self) -> None:
        node = Node()
        self.addCleanup(node.close)
        executor = SingleThreadedExecutor()
        self.addCleanup(executor.shutdown)
        executor.add_node(node)
        ticks: List[float] = []
        heard: List[str] = []
        timer = node.create_timer(10.0, ticks.append)
        node.create_subscription("topic", String, lambda message: heard.append(message.data))
        publisher = node.create_publisher("topic", String)
        client = node.create_client("nowhere", Trigger)
        node.start()

        def ticked() -> bool:
            self.step(0.0)
            return bool(ticks)

        wait_until(ticked, lambda: "no first tick")
        publisher.publish("still")
        wait_until(lambda: heard == ["still"], lambda: str(heard))
        with self.assertRaises(CallError):  # by the machine's clock
            client.call(TriggerRequest(), timeout=0.2)
        self.assertFalse(client.wait_for_service(0.2))
        self.assertEqual(ticks, [0.0])
        for count in (2, 3):
            self.step(1.0)
            wait_until(lambda: len(ticks) == count, lambda: str(ticks))
        self.assertEqual(timer.skipped, 18)
        self.assertTrue(executor.shutdown(TIMEOUT_S))


if __name__ == "__main__":
    init_node("test_executors_clock")
    rosrun("nodekit", "executors_clock", "test_executors_clock")
