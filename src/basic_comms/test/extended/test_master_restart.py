#!/usr/bin/env python3
"""Connected nodes continue without a master, and register everything with a new one."""

import unittest
from typing import Any, List

import rosgraph
from helpers.machine_lag import measured_lag
from helpers.sample_gaps import gaps
from helpers.tcpros import Tap
from roslib.packages import find_node
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg
from nodekit.testing.processes import Master, Process, Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

RATE = 100.0  # Hz


class RestartedMaster(unittest.TestCase):
    """The talker with its listener, and the signal generator with its process."""

    def setUp(self) -> None:
        self.master = Master()
        self.addCleanup(lambda: self.master.kill())
        self.server = Server(self.master.uri)

    def start(self, name: str, *arguments: str) -> Process:
        node = Process(
            find_node("basic_comms", name + ".py")[0],
            arguments,
            {"ROS_MASTER_URI": self.master.uri},
        )
        self.addCleanup(node.end)
        return node

    def registrations(self) -> Any:
        """Return the registrations, sorted, and all parameters."""
        state = self.server.master.getSystemState("/test")[2]
        return [sorted((name, sorted(nodes)) for name, nodes in part) for part in state]

    def parameters(self) -> Any:
        """Return all parameters of the nodes."""
        nodes = ("talker", "signal_generator", "process")
        return {name: self.server.get("/" + name) for name in nodes}

    def tap(self, node: str, topic: str, kind: Any) -> Tap:
        tap = Tap(rosgraph.Master("/test", self.master.uri).lookupNode(node), topic, kind)
        self.addCleanup(tap.close)
        return tap

    def test_connections_stay_and_registrations_come_back(self) -> None:
        nodes = [self.start(name) for name in ("listener", "talker", "process")]
        nodes.append(self.start("signal_generator", f"_rate:={RATE}", "_amplitude:=3.0"))
        listener = nodes[0]
        listener.wait_for_log("I heard")
        signal = self.tap_when_up("/signal_generator", "/signal", signal_msg)
        answers = self.tap_when_up("/process", "/proc_signal", Float32)
        self.server.set("/signal_generator/offset", 0.5)
        with measured_lag(lambda: [node.popen.pid for node in nodes]) as lag:
            times = [self.wait_for_offset(signal)]
            self.restart_master(nodes)
            times += self.read_until_now(signal)
        # The connection of before has brought each sample.
        self.assertEqual(gaps(times, RATE, lag), [])
        self.assertGreater(times[-1], times[0])
        answers.read()

        heard = len(listener.logged("I heard"))
        wait_until(lambda: len(listener.logged("I heard")) > heard, lambda: "the listener is deaf")
        newcomer = self.start("listener", "__name:=newcomer")
        newcomer.wait_for_log("I heard", "/talker")
        self.tap("/signal_generator", "/signal", signal_msg).read()

    def restart_master(self, nodes: List[Process]) -> None:
        """Replace the master, and wait until it knows all that the previous one knew."""
        registered, parameters = self.registrations(), self.parameters()
        self.assertEqual(parameters["signal_generator"]["amplitude"], 3.0)
        self.master.kill()
        silent, answers = "the master does not answer", "the master answers again"
        for node in nodes:
            node.wait_for_log("WARN", silent)
        counts = [len(node.logged(silent)) - len(node.logged(answers)) for node in nodes]
        self.assertEqual(counts, [1] * len(nodes))
        self.master.start()
        self.server = Server(self.master.uri)
        wait_until(
            lambda: self.registrations() == registered,
            lambda: f"registered was {registered}, now {self.registrations()}",
        )
        wait_until(
            lambda: self.parameters() == parameters,
            lambda: f"parameters were {parameters}, now {self.parameters()}",
        )
        for node in nodes:
            # Logged after the last registration, which may be a moment after the master has it.
            node.wait_for_log("WARN", "the master was restarted")
            # On a busy machine the new master may not answer in time: another pair of lines.
            wait_until(
                lambda: len(node.logged(silent)) == len(node.logged(answers)),
                lambda: str(node.logged("the master")),
            )
            self.assertEqual(len(node.logged("the master was restarted")), 1, node.logged())
            self.assertEqual(node.logged("Traceback"), [])

    def tap_when_up(self, node: str, topic: str, kind: Any) -> Tap:
        wait_until(
            lambda: (
                [topic, [node]] in self.server.master.getSystemState("/test")[2][0]
                and node + "/set_logger_level" in self.server.services()
            ),
            lambda: node + " did not come up",
        )
        return self.tap(node, topic, kind)

    def wait_for_offset(self, signal: Tap) -> float:
        """Read on until a change of the offset shows; return the time of that sample."""
        sample = wait_until(
            lambda: next((s for s in [signal.read()] if s.signal_y > 3.4), None),
            lambda: "the offset does not show",
        )
        return float(sample.time_x)

    def read_until_now(self, signal: Tap) -> List[float]:
        """Return the times of the samples of a connection that was not read for a while."""
        now = self.tap("/signal_generator", "/signal", signal_msg).read().time_x
        times = [signal.read().time_x]
        while times[-1] < now:
            times.append(signal.read().time_x)
        return times


if __name__ == "__main__":
    rosrun("basic_comms", "master_restart", RestartedMaster)
