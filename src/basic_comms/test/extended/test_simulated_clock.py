#!/usr/bin/env python3
"""All nodes with a simulated clock that stops, jumps, runs tenfold, or is from a bag."""

import math
import os
import signal
import subprocess
import tempfile
import unittest
from typing import Any, Dict, List, Set
from xmlrpc.client import ServerProxy

import rosbag
import rosgraph
import rospy
from rosgraph_msgs.msg import Clock, Log
from std_msgs.msg import Float32, String

from basic_comms.msg import signal_msg
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

NODES = ("/talker", "/listener", "/signal_generator", "/process", "/fleet", "/recorded/process")
PERIOD = 0.1  # s, of the generator and the talker
TENFOLD = "10"


class OnSimulatedClock(unittest.TestCase):
    """The nodes are the same in all tests; each has to find them well."""

    graph: Graph
    pids: Dict[str, int]

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_simulated_clock")
        cls.graph = Graph()
        wait_until(lambda: cls.graph.initialised(*NODES), lambda: str(cls.graph.nodes()))
        cls.pids = {node: cls.graph.pid(node) for node in NODES}

    def setUp(self) -> None:
        self.signal = self.recorder("/signal", signal_msg)
        self.answers = self.recorder("/proc_signal", Float32)
        self.chatter = self.recorder("/chatter", String)
        self.log = self.recorder("/rosout", Log)

    def tearDown(self) -> None:
        self.assertEqual({node: self.graph.pid(node) for node in NODES}, self.pids)
        self.assertEqual([line.msg for line in self.log.messages() if "raceback" in line.msg], [])

    def recorder(self, topic: str, kind: type) -> MessageRecorder:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def steps(self) -> List[float]:
        """Return the intervals between samples, in periods."""
        times = [sample.time_x for sample in self.signal.messages()]
        return [round((later - one) / PERIOD, 4) for one, later in zip(times, times[1:])]

    def said_at(self) -> List[float]:
        """Return the times in the talker's messages."""
        return [round(float(message.data.split()[-1]), 6) for message in self.chatter.messages()]

    def heard(self) -> bool:
        """Return whether the listener has logged the talker's last message."""
        last = self.chatter.messages()[-1].data
        return any(line.name == "/listener" and last in line.msg for line in self.log.messages())

    def test_pause_and_jumps(self) -> None:
        clock = rospy.Publisher("/clock", Clock, queue_size=100)
        self.addCleanup(clock.unregister)
        wait_until(
            lambda: (
                subscribers(rospy.get_name(), "/clock") >= set(NODES)
                and subscribers("/signal_generator", "/signal") >= {"/process", rospy.get_name()}
                and rospy.get_name() in subscribers("/process", "/proc_signal")
                and rospy.get_name() in subscribers("/talker", "/chatter")
            ),
            lambda: f"/clock has {subscribers(rospy.get_name(), '/clock')}",
        )

        def show(*times: float) -> None:
            for time in times:
                before = self.signal.count(), self.answers.count(), self.chatter.count()
                clock.publish(Clock(rospy.Time.from_sec(time)))
                wait_until(
                    lambda: (
                        self.signal.count() > before[0]
                        and self.answers.count() > before[1]
                        and self.chatter.count() > before[2]
                    ),
                    lambda: f"nothing at {time} s",
                )

        show(100.0, 100.1, 100.2)
        for _ in range(20):
            clock.publish(Clock(rospy.Time.from_sec(100.2)))
        show(100.3, 50.0, 50.1, 5000.0, 5000.1)
        self.assertEqual(self.said_at(), [100.0, 100.1, 100.2, 100.3, 50.0, 50.1, 5000.0, 5000.1])
        self.assertEqual(self.steps(), [1, 1, 1, 1, 1, 49499, 1])
        self.assertEqual([line.msg for line in self.log.messages() if "s late" in line.msg], [])

    def test_bag_that_plays_tenfold_and_in_a_loop(self) -> None:
        recorded = self.recorder("/recorded/proc_signal", Float32)
        with tempfile.TemporaryDirectory() as place:
            path = os.path.join(place, "signal.bag")
            write_bag(path)
            play = subprocess.Popen(
                ["rosbag", "play", "--quiet", "--clock", "--hz=1000", "-l", "-r", TENFOLD, path],
                start_new_session=True,
            )
            # Ctrl-C also reaches its child processes, as in a terminal.
            self.addCleanup(play.wait, TIMEOUT_S)
            self.addCleanup(os.killpg, play.pid, signal.SIGINT)
            wait_until(
                lambda: laps(self.said_at()) >= 3 and recorded.count() > 150,
                lambda: f"{int(laps(self.said_at()))} laps, {recorded.count()} answers",
            )
            wait_until(self.heard, lambda: "the listener is deaf")
        steps = self.steps()
        self.assertGreater(min(steps), 0)
        self.assertTrue(all(step.is_integer() for step in steps), steps)
        self.assertTrue(all(math.isfinite(answer.data) for answer in recorded.messages()))
        warnings = [line for line in self.log.messages() if "went back" in line.msg]
        self.assertEqual({line.name for line in warnings}, {"/recorded/process"})


def subscribers(node: str, topic: str) -> Set[str]:
    """Return the names of the nodes that are connected to a topic of another node."""
    with ServerProxy(rosgraph.Master("/test").lookupNode(node)) as slave:
        connections: Any = slave.getBusInfo("/test")
    return {info[1] for info in connections[2] if info[2] == "o" and info[4] == topic}


def laps(times: List[float]) -> int:
    """Count how often the time went back."""
    return sum(later < one for one, later in zip(times, times[1:]))


def write_bag(path: str) -> None:
    """Record three seconds of a sine, 20 samples a second."""
    with rosbag.Bag(path, "w") as bag:
        for number in range(60):
            time = number / 20.0
            sample = signal_msg(2.0, 6.0, time, 2.0 * math.sin(6.0 * time))
            bag.write("/recorded/signal", sample, rospy.Time.from_sec(1000.0 + time))


if __name__ == "__main__":
    rosrun("basic_comms", "simulated_clock", OnSimulatedClock)
