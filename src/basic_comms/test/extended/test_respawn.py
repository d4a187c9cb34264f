#!/usr/bin/env python3
"""A node that is killed without warning and started again by roslaunch is as good as before."""

import unittest
from pathlib import Path
from typing import List, Optional

import rospy
from helpers.kill_rounds import Stream, kill_rounds
from helpers.machine_lag import measured_lag
from helpers.sample_gaps import gaps
from rosgraph_msgs.msg import Log

from basic_comms.msg import signal_msg
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import Launched, launched
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S

#: A launch file with every node of the package; see there for its args.
EVERY_NODE = str(Path(__file__).resolve().parents[1] / "helpers" / "every_node.launch")
#: Rate of its signal generator [Hz].
RATE = 200.0
#: How often each node is killed here.
ROUNDS = 3
#: Longest silence after a node's return on an idle machine [s].
SILENCE = 2.0


class Respawn(unittest.TestCase):
    """Each test kills one node while all are running."""

    launch: Launched

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_respawn")
        running = launched(EVERY_NODE + " respawn:=true")
        cls.launch = running.__enter__()
        cls.addClassCleanup(running.__exit__, None, None, None)
        cls.launch.wait_until_up()
        # The later comparison needs the complete graph.
        for node in ("talker", "process", "signal_generator", "fleet", "Group2/process"):
            rospy.wait_for_service(f"/{node}/describe", TIMEOUT_S)  # registered last
        cls.launch.graph.wait_for_subscribers("/chatter", "/listener")

    def stream(self, topic: str) -> Stream:
        """Count messages on a topic from now on."""
        return self.recorder(topic, rospy.AnyMsg).count

    def recorder(self, topic: str, kind: type) -> MessageRecorder:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        recorder.wait_for(lambda message: True)
        return recorder

    def kill(self, node: str, *streams: Stream, unbroken: Optional[MessageRecorder] = None) -> None:
        """Kill a node several times, and check its returns.

        :param unbroken: recorder of the generator's samples, of which none is lost meanwhile
        """
        with measured_lag(self.pids) as lag:
            if unbroken:
                unbroken.clear()
            rounds = kill_rounds(self.launch, node, list(streams), ROUNDS)
            times = [sample.time_x for sample in unbroken.messages()] if unbroken else []
        silent = [each.silent for each in rounds]
        print(f"{node}: silent for up to {1000.0 * max(silent):.0f} ms after its return")
        self.assertLess(max(silent), lag.allowed(SILENCE))
        if unbroken:
            self.assertGreater(len(times), 100)
            self.assertEqual(gaps(times, RATE, lag), [])

    def pids(self) -> List[int]:
        return [process.pid for process in self.launch.processes().values()]

    def test_talker(self) -> None:
        self.kill("/talker", self.stream("chatter"), self.heard_by_the_listener())

    def test_listener(self) -> None:
        chatter = self.stream("chatter")
        self.kill("/listener", chatter, self.heard_by_the_listener())

    def heard_by_the_listener(self) -> Stream:
        log = self.recorder("/rosout", Log)

        def count() -> int:
            return sum("I heard" in line.msg for line in log.messages())

        return count

    def test_signal_generator(self) -> None:
        self.kill("/signal_generator", self.stream("signal"), self.stream("proc_signal"))

    def test_process(self) -> None:
        signal = self.recorder("signal", signal_msg)
        self.kill("/process", self.stream("proc_signal"), unbroken=signal)

    def test_fleet(self) -> None:
        signal = self.recorder("signal", signal_msg)
        groups = [self.stream(f"Group{number}/proc_signal") for number in (1, 2)]
        self.kill("/fleet", *groups, unbroken=signal)


if __name__ == "__main__":
    rosrun("basic_comms", "respawn", Respawn)
