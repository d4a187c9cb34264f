#!/usr/bin/env python3
"""End of nodes: exit status, last log lines, and registrations left with the master."""

import os
import signal
import subprocess
import time
import unittest
from contextlib import contextmanager
from typing import Iterator

import roslib.packages
import rospy

from nodekit.testing.graph import Graph
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: Nodes, and their ends: of each Ctrl-C, of one node and of several in one the others.
ENDS = (
    ("talker", "SIGINT"),
    ("listener", "SIGINT"),
    ("signal_generator", "SIGINT"),
    ("process", "SIGINT"),
    ("fleet", "SIGINT"),
    ("process", "SIGTERM"),
    ("fleet", "SIGTERM"),
    ("talker", "rosnode kill"),
    ("fleet", "rosnode kill"),
)


class NodeLife(unittest.TestCase):
    """Each test starts its own nodes."""

    graph: Graph

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_node_life")
        cls.graph = Graph()

    @contextmanager
    def started(self, node: str, *arguments: str) -> "Iterator[subprocess.Popen[str]]":
        """Start a node; kill it if it still runs at the end."""
        program = node if node == "fleet" else node + ".py"
        process = subprocess.Popen(
            [*roslib.packages.find_node("basic_comms", program), *arguments],
            env={**os.environ, "PYTHONWARNINGS": "error::ResourceWarning"},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()

    def wait_until_up(self, node: str) -> None:
        """Wait until a node is known to the master."""
        name = "/" + node
        wait_until(lambda: name in self.graph.nodes(), lambda: name + " did not come up")

    def assert_ends_cleanly(self, node: str, process: "subprocess.Popen[str]") -> None:
        """Check the exit status, the last output and the master's state."""
        _, errors = process.communicate(timeout=TIMEOUT_S)
        self.assertEqual(process.returncode, 0, errors)
        self.assertNotIn("Traceback", errors)
        self.assertNotIn("Warning", errors)
        wait_until(
            lambda: "/" + node not in self.graph.nodes(), lambda: node + " is still registered"
        )

    def test_every_node_ends_with_status_0(self) -> None:
        for node, end in ENDS:
            with self.subTest(node=node, end=end), self.started(node) as process:
                self.wait_until_up(node)
                if end == "rosnode kill":
                    self.graph.kill("/" + node)
                else:
                    process.send_signal(signal.Signals[end])
                self.assert_ends_cleanly(node, process)

    def test_sigterm_soon_after_ctrl_c_changes_no_status(self) -> None:
        with self.started("talker") as process:
            self.wait_until_up("talker")
            process.send_signal(signal.SIGINT)
            deadline = time.monotonic() + TIMEOUT_S
            while process.poll() is None and time.monotonic() < deadline:
                process.send_signal(signal.SIGTERM)
                time.sleep(0.0005)
            self.assert_ends_cleanly("talker", process)

    def test_interrupt_of_a_talker_that_sleeps_for_a_quarter_of_an_hour(self) -> None:
        with self.started("talker", "_rate:=0.001") as process:
            wait_until(
                lambda: self.graph.publishers("/chatter"), lambda: "the talker did not come up"
            )
            process.send_signal(signal.SIGINT)
            self.assert_ends_cleanly("talker", process)
        self.graph.delete_parameter("/talker/rate")

    def test_a_refused_start_ends_with_status_1_and_a_sentence(self) -> None:
        cases = {
            (
                "talker",
                "_rate:=0",
            ): "parameter /talker/rate: refused 0: must be a number in [1e-06",
            ("fleet", "_prefix:=a b"): "parameter /fleet/prefix: refused 'a b': must be letters",
            ("listener", "__name:=a b"): "node name 'a b': must be a letter",
            ("listener", "__ns:=ä ö"): "namespace '/ä ö/': must be letters",
            ("listener", "chatter:=a b"): "name '/a b': must be letters",
            (
                "signal_generator",
                "signal:=signal_generator/status",
            ): "refused std_msgs/String: must be basic_comms/signal_msg, as elsewhere in this",
            (
                "signal_generator",
                "/signal_generator/enable:=/signal_generator/reset",
            ): "service /signal_generator/reset: refused: this process offers it already",
            ("talker", '_rate:={a: [1"'): "argument '_rate:={a: [1\"': must have one YAML value",
        }
        for (node, argument), sentence in cases.items():
            with self.subTest(node=node), self.started(node, argument) as process:
                _, errors = process.communicate(timeout=TIMEOUT_S)
                self.assertEqual(process.returncode, 1, errors)
                self.assertIn(sentence, errors)
                self.assertNotIn("Traceback", errors)
            for name in self.graph.parameters():
                if name.startswith(f"/{node}/"):
                    self.graph.delete_parameter(name)


if __name__ == "__main__":
    rosrun("basic_comms", "node_life", NodeLife)
