#!/usr/bin/env python3
"""Texts of 10 MB and ten thousand texts a second: the listener keeps up and does not grow."""

import re
import time
import unittest
from typing import List

import rospy
from helpers.process_facts import usage
from roslib.packages import find_node
from std_msgs.msg import String

from nodekit import Publisher
from nodekit.testing.graph import Graph
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

RATE, COUNT = 10000.0, 20000
HUGE = 10_000_000  # characters
#: Memory that the listener may keep, which malloc decides [bytes]: far less than it receives.
ALLOWANCE = 5 * HUGE


class ChatterExtremes(unittest.TestCase):
    """A separate listener for each test."""

    def setUp(self) -> None:
        self.listener = Process(find_node("basic_comms", "listener.py")[0])
        self.addCleanup(self.listener.end)
        self.publisher = Publisher("/chatter", String)
        self.addCleanup(self.publisher.close)
        self.publisher.open()
        wait_until(lambda: self.publisher.statistics(), lambda: "the listener did not come")
        self.say_until_heard("first")
        # This connection may be the last, and has a thread.
        Graph().wait_until_heard("/listener", "/rosout", "/rosout")
        self.pid = self.listener.popen.pid
        self.before = usage(self.pid)

    def say_until_heard(self, text: str) -> None:
        """Repeat a text until it is logged: in a full second it may be left out."""

        def heard() -> List[str]:
            wait_until(lambda: not self.publisher.statistics()[0].stalled, lambda: "stalled")
            self.publisher.publish(String(text))
            return self.listener.logged(f"I heard '{text}'")

        wait_until(heard, lambda: f"log: {self.listener.logged()[-3:]}")

    def lost(self) -> int:
        """Return how many texts this busy machine kept from the listener."""
        return self.publisher.statistics()[0].lost

    def assert_small(self) -> None:
        wait_until(
            lambda: usage(self.pid).memory < self.before.memory + ALLOWANCE,
            lambda: f"{usage(self.pid)}, before {self.before}",
        )
        self.assertLessEqual(usage(self.pid).threads, self.before.threads)
        self.assertEqual(self.listener.logged("Traceback"), [])
        self.assertEqual(self.listener.interrupt(), 0)

    def test_ten_kilohertz(self) -> None:
        start = time.monotonic()
        for number in range(COUNT):
            self.publisher.publish(String(f"text {number}"))
            pause = start + number / RATE - time.monotonic()
            if pause > 0:
                time.sleep(pause)
        wait_until(
            lambda: self.counted() + self.lost() >= COUNT,
            lambda: f"counted {self.counted()} of {COUNT}",
        )
        self.assertEqual(self.counted() + self.lost(), COUNT)
        seconds = time.monotonic() - start + 2.0
        self.assertLess(len(self.listener.logged("I heard 'text")), 12 * seconds)
        self.assert_small()

    def counted(self) -> int:
        """Return how many texts the listener has logged, or said that it left out."""
        rests = (re.search(r"and (\d+) more", line) for line in self.listener.logged("more in the"))
        left_out = sum(int(rest.group(1)) for rest in rests if rest)
        return len(self.listener.logged("I heard 'text")) + left_out

    def test_ten_megabytes(self) -> None:
        for number in range(10):
            self.publisher.publish(String(f"{number} {'x' * HUGE}"))
            self.say_until_heard(f"after {number}")
        self.assertTrue(self.listener.logged("I heard '0 xxx", "xxx' from /"))
        self.assertLess(max(map(len, self.listener.logged("I heard"))), 2000)
        self.assert_small()


if __name__ == "__main__":
    rospy.init_node("test_chatter_extremes")
    rosrun("basic_comms", "chatter_extremes", ChatterExtremes)
