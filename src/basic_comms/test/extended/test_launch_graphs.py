#!/usr/bin/env python3
"""Each of the course's launch files brings up the graph that its table row promises."""

import os
import stat
import tempfile
import unittest
from contextlib import ExitStack
from math import pi
from typing import Tuple
from unittest import mock

from nodekit.testing.graph import Graph
from nodekit.testing.launching import Launched, launched
from nodekit.testing.running import rosrun

#: Launch files that are started once for all tests; activities 1 to 3 share node names.
TOGETHER = (
    "basic_comms activity4.launch",
    "basic_comms cw1.launch",
    "basic_comms cw1.launch ns:=robot/arm signal_amplitude:=4 process_offset:=-1.5",
    "basic_comms signal_gen.launch __ns:=generator amplitude:=1e1 rate:=20",
    "basic_comms process.launch __ns:=conditioner keep_positive:=false",
    "basic_comms talker_listener.launch",
    "basic_comms talker_listener.launch prefix:=lab topic_name:=gossip rate:=5",
    "basic_comms groups.launch prefix:=Member count:=2",
)
GROUPS = ("/Group1/talker", "/Group1/listener", "/Group2/talker", "/Group2/listener")


class LaunchGraphs(unittest.TestCase):
    """Nodes, topics and parameters of the launch files that are not about a feature."""

    launch: Launched
    graph: Graph

    @classmethod
    def setUpClass(cls) -> None:
        with ExitStack() as stack:
            cls.launch = stack.enter_context(launched(*TOGETHER))
            cls.graph = cls.launch.graph
            cls.launch.wait_until_up()
            cls.addClassCleanup(stack.pop_all().close)

    def assert_signal_chain(self, namespace: str) -> None:
        """Check that a generator feeds the process there, and no other node."""
        generator, process = namespace + "/signal_generator", namespace + "/process"
        self.graph.wait_for_publishers(namespace + "/signal", generator)
        self.graph.wait_for_subscribers(namespace + "/signal", process)
        self.graph.wait_for_publishers(namespace + "/proc_signal", process)
        self.assertEqual(self.graph.topics()[namespace + "/signal"], "basic_comms/signal_msg")
        self.assertEqual(self.graph.topics()[namespace + "/proc_signal"], "std_msgs/Float32")

    def test_activity1_has_two_groups_that_hear_only_themselves(self) -> None:
        """As activities 2 and 3, which add texts: the unit tests compare them."""
        with launched("basic_comms activity1.launch") as launch:
            launch.graph.wait_for_nodes(*GROUPS)
            for group in ("/Group1", "/Group2"):
                launch.graph.wait_for_publishers(group + "/chatter", group + "/talker")
                launch.graph.wait_for_subscribers(group + "/chatter", group + "/listener")
                self.assertEqual(launch.graph.topics()[group + "/chatter"], "std_msgs/String")
            self.assertEqual(launch.graph.publishers("/chatter"), set())

    def test_activity4_takes_parameters_from_yaml(self) -> None:
        self.assert_signal_chain("/Group1")
        self.graph.wait_for_parameters(
            "/Group1/signal_generator", {"rate": 20.0, "amplitude": 3.0, "frequency": pi}
        )
        self.graph.wait_for_parameters(
            "/Group1/process",
            {"amplitude_scale": 0.25, "phase_shift": pi / 4, "offset": 1.0, "keep_positive": False},
        )

    def test_signal_gen_is_the_generator_alone(self) -> None:
        node = "/generator/signal_generator"
        self.graph.wait_for_nodes(node, under="/generator/")
        self.graph.wait_for_publishers("/generator/signal", node)
        self.graph.wait_for_parameters(node, {"amplitude": 10.0, "rate": 20.0, "frequency": 2 * pi})

    def test_process_is_the_process_alone(self) -> None:
        node = "/conditioner/process"
        self.graph.wait_for_nodes(node, under="/conditioner/")
        self.graph.wait_for_subscribers("/conditioner/signal", node)
        self.graph.wait_for_publishers("/conditioner/proc_signal", node)
        self.graph.wait_for_parameters(node, {"keep_positive": False, "amplitude_scale": 0.5})

    def test_cw1_at_the_root(self) -> None:
        self.assert_signal_chain("")
        self.graph.wait_for_parameters("/signal_generator", {"amplitude": 2.0})

    def test_cw1_in_a_namespace_with_parameters(self) -> None:
        self.assert_signal_chain("/robot/arm")
        self.graph.wait_for_parameters(
            "/robot/arm/signal_generator", {"amplitude": 4.0, "offset": 0.0}
        )
        self.graph.wait_for_parameters("/robot/arm/process", {"offset": -1.5})

    def test_groups_start_one_cw1_each(self) -> None:
        self.assert_signal_chain("/Member1")
        self.assert_signal_chain("/Member2")
        self.assertEqual(len(self.graph.nodes(under="/Member")), 4)

    def test_talker_listener_by_default(self) -> None:
        self.graph.wait_for_publishers("/chatter", "/talker")
        self.graph.wait_for_subscribers("/chatter", "/listener")

    def test_talker_listener_elsewhere(self) -> None:
        self.graph.wait_for_nodes("/lab/talker", "/lab/listener", under="/lab/")
        self.graph.wait_for_publishers("/lab/gossip", "/lab/talker")
        self.graph.wait_for_subscribers("/lab/gossip", "/lab/listener")
        self.assertEqual(self.graph.publishers("/lab/chatter"), set())
        self.graph.wait_for_parameters("/lab/talker", {"rate": 5.0})

    def test_terminals_open_an_xterm_per_node(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            journal, path = self.fake_xterm(folder)
            command = "basic_comms talker_listener.launch prefix:=in_xterm terminals:=true"
            with mock.patch.dict(os.environ, PATH=path), launched(command) as launch:
                launch.graph.wait_for_nodes("/in_xterm/talker", "/in_xterm/listener")
            with open(journal) as lines:
                opened = sorted(os.path.basename(line.split()[1]) for line in lines)
        self.assertEqual(opened, ["listener.py", "talker.py"])

    def fake_xterm(self, folder: str) -> Tuple[str, str]:
        """Make an xterm that notes its arguments and runs the command after -e."""
        journal, program = os.path.join(folder, "journal"), os.path.join(folder, "xterm")
        with open(program, "w") as script:
            script.write(f'#!/bin/sh\necho "$@" >> "{journal}"\nshift\nexec "$@"\n')
        os.chmod(program, os.stat(program).st_mode | stat.S_IXUSR)
        return journal, folder + os.pathsep + os.environ["PATH"]


if __name__ == "__main__":
    rosrun("basic_comms", "launch_graphs", LaunchGraphs)
