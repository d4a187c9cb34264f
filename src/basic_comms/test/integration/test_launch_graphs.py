#!/usr/bin/env python3
"""Each of the course's launch files brings up the graph that its table row promises."""

import os
import stat
import tempfile
import unittest
from math import pi
from typing import Tuple
from unittest import mock

import rostest
from helpers.graph import Graph
from helpers.launching import launch_file, launched

GROUPS = ("/Group1/talker", "/Group1/listener", "/Group2/talker", "/Group2/listener")

TEXTS = {
    "/Message": "global message",
    "/Group1/Message": "local message",
    "/Group2/Message": "local message",
    "/Group1/talker/Message": "private message",
    "/Group2/talker/Message": "private message",
}


class LaunchGraphs(unittest.TestCase):
    """Nodes, topics and parameters of the launch files that are not about a feature."""

    def assert_isolated_groups(self, graph: Graph) -> None:
        graph.wait_for_nodes(*GROUPS)
        for group in ("/Group1", "/Group2"):
            graph.wait_for_publishers(group + "/chatter", group + "/talker")
            graph.wait_for_subscribers(group + "/chatter", group + "/listener")
        self.assertEqual(graph.publishers("/chatter"), set())

    def assert_signal_chain(self, graph: Graph, namespace: str = "") -> None:
        generator, process = namespace + "/signal_generator", namespace + "/process"
        graph.wait_for_nodes(generator, process)
        graph.wait_for_publishers(namespace + "/signal", generator)
        graph.wait_for_subscribers(namespace + "/signal", process)
        graph.wait_for_publishers(namespace + "/proc_signal", process)
        self.assertEqual(graph.topics()[namespace + "/signal"], "basic_comms/signal_msg")
        self.assertEqual(graph.topics()[namespace + "/proc_signal"], "std_msgs/Float32")

    def assert_parameters(self, graph: Graph, **expected: object) -> None:
        """Compare parameters; in their names here, __ stands for a slash."""
        for name, value in expected.items():
            path = "/" + name.replace("__", "/")
            self.assertEqual(graph.parameter(path), value, path)

    def test_activity1(self) -> None:
        with launched(launch_file("activity1.launch")) as launch:
            self.assert_isolated_groups(launch.graph)
            self.assertEqual(launch.graph.topics()["/Group1/chatter"], "std_msgs/String")
            self.assertEqual(launch.graph.topics()["/Group2/chatter"], "std_msgs/String")

    def test_activities_2_and_3_set_the_same_parameters_in_two_ways(self) -> None:
        for name in ("activity2.launch", "activity3.launch"):
            with self.subTest(name), launched(launch_file(name), "scope:=local") as launch:
                self.assert_isolated_groups(launch.graph)
                found = {path: launch.graph.parameter(path) for path in TEXTS}
                self.assertEqual(found, TEXTS)
                self.assert_parameters(
                    launch.graph,
                    Group1__talker__message_scope="local",
                    Group2__talker__message_scope="local",
                )

    def test_activity4_takes_parameters_from_yaml(self) -> None:
        with launched(launch_file("activity4.launch")) as launch:
            self.assert_signal_chain(launch.graph, "/Group1")
            self.assert_parameters(
                launch.graph,
                Group1__signal_generator__rate=20.0,
                Group1__signal_generator__amplitude=3.0,
                Group1__signal_generator__frequency=pi,
                Group1__process__amplitude_scale=0.25,
                Group1__process__phase_shift=pi / 4,
                Group1__process__offset=1.0,
                Group1__process__keep_positive=False,
            )

    def test_signal_gen_is_the_generator_alone(self) -> None:
        with launched(launch_file("signal_gen.launch"), "amplitude:=1e1", "rate:=20") as launch:
            launch.graph.wait_for_nodes("/signal_generator")
            launch.graph.wait_for_publishers("/signal", "/signal_generator")
            self.assert_parameters(
                launch.graph,
                signal_generator__amplitude=10.0,
                signal_generator__rate=20.0,
                signal_generator__frequency=2 * pi,
            )

    def test_process_is_the_process_alone(self) -> None:
        with launched(launch_file("process.launch"), "keep_positive:=false") as launch:
            launch.graph.wait_for_nodes("/process")
            launch.graph.wait_for_subscribers("/signal", "/process")
            launch.graph.wait_for_publishers("/proc_signal", "/process")
            self.assert_parameters(
                launch.graph, process__keep_positive=False, process__amplitude_scale=0.5
            )

    def test_cw1_at_the_root(self) -> None:
        with launched(launch_file("cw1.launch")) as launch:
            self.assert_signal_chain(launch.graph)

    def test_cw1_in_a_namespace_with_parameters(self) -> None:
        arguments = ("ns:=robot/arm", "signal_amplitude:=4", "process_offset:=-1.5")
        with launched(launch_file("cw1.launch"), *arguments) as launch:
            self.assert_signal_chain(launch.graph, "/robot/arm")
            self.assertEqual(launch.graph.publishers("/signal"), set())
            self.assert_parameters(
                launch.graph,
                robot__arm__signal_generator__amplitude=4.0,
                robot__arm__signal_generator__offset=0.0,
                robot__arm__process__offset=-1.5,
            )

    def talks(self, topic: str, namespace: str, *arguments: str) -> None:
        with launched(launch_file("talker_listener.launch"), *arguments) as launch:
            talker, listener = namespace + "/talker", namespace + "/listener"
            launch.graph.wait_for_nodes(talker, listener)
            launch.graph.wait_for_publishers(topic, talker)
            launch.graph.wait_for_subscribers(topic, listener)
            self.assertEqual(launch.graph.publishers(namespace + "/chatter") - {talker}, set())

    def test_talker_listener_by_default(self) -> None:
        self.talks("/chatter", "")

    def test_talker_listener_elsewhere(self) -> None:
        self.talks("/lab/gossip", "/lab", "prefix:=lab", "topic_name:=gossip", "rate:=5")

    def test_terminals_open_an_xterm_per_node(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            journal, path = self.fake_xterm(folder)
            with mock.patch.dict(os.environ, PATH=path):
                with launched(launch_file("talker_listener.launch"), "terminals:=true") as launch:
                    launch.graph.wait_for_nodes("/talker", "/listener")
            with open(journal) as lines:
                opened = sorted(os.path.basename(line.split()[1]) for line in lines)
        self.assertEqual(opened, ["listener.py", "talker.py"])

    def fake_xterm(self, folder: str) -> Tuple[str, str]:
        """Make an xterm that notes its arguments and runs the command after -e."""
        journal, program = os.path.join(folder, "journal"), os.path.join(folder, "xterm")
        with open(program, "w") as script:
            script.write('#!/bin/sh\necho "$@" >> "%s"\nshift\nexec "$@"\n' % journal)
        os.chmod(program, os.stat(program).st_mode | stat.S_IXUSR)
        return journal, folder + os.pathsep + os.environ["PATH"]


if __name__ == "__main__":
    rostest.rosrun("basic_comms", "launch_graphs", LaunchGraphs)
