#!/usr/bin/env python3
"""Files of launch/features behave as described in their comments; of values, see the unit tests."""

import os
import tempfile
import unittest
from contextlib import ExitStack
from math import pi
from typing import Dict

import rosgraph

from nodekit.testing.launching import Launched, Process, launch_file, launched
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

#: Launch files that are started once for all tests, each in its namespace.
TOGETHER = {
    "group_ns": "group_ns.launch",
    "remap": "remap.launch",
    "env": "env.launch",
    "rosparam": "rosparam.launch rate:=5.0",
    "node_args": "node_args.launch",
    "respawn": "respawn.launch delay:=0.2",
    "launch_prefix": "launch_prefix.launch",
    "machine": "machine.launch",
    "param_types": "param_types.launch",
    "with_bytes": "param_types.launch bytes:=true",
    "delayed_start": "delayed_start.launch delay:=2",
}


class LaunchFeatures(unittest.TestCase):
    """One test per file; more for files with alternatives."""

    launch: Launched
    at_once: Dict[str, Process]

    @classmethod
    def setUpClass(cls) -> None:
        rosgraph.Master("/test").setParam("/rosparam/rosparam_demo/stale", 1)
        commands = [f"basic_comms features/{TOGETHER[ns]} __ns:={ns}" for ns in TOGETHER]
        with ExitStack() as stack:
            cls.launch = stack.enter_context(launched(*commands))
            cls.at_once = cls.launch.processes()
            cls.launch.wait_until_up()
            cls.addClassCleanup(stack.pop_all().close)

    def assert_nodes(self, namespace: str, *names: str) -> None:
        """Wait until exactly these nodes are in a namespace."""
        under = namespace + "/"
        self.launch.graph.wait_for_nodes(*(under + name for name in names), under=under)

    def test_group_ns(self) -> None:
        """Course 001-feature-4."""
        self.assert_nodes(
            "/group_ns", "left/talker", "left/inner/talker", "far/talker", "right/listener"
        )
        graph = self.launch.graph
        for place in ("/group_ns/left", "/group_ns/left/inner", "/group_ns/far"):
            graph.wait_for_publishers(place + "/chatter", place + "/talker")
        graph.wait_for_subscribers("/group_ns/right/chatter", "/group_ns/right/listener")

    def test_remap_reaches_as_far_as_its_group(self) -> None:
        """Course 001-feature-2."""
        self.assert_nodes("/remap", "before", "inside", "own", "after")
        graph = self.launch.graph
        graph.wait_for_publishers("/remap/chatter", "/remap/before", "/remap/after")
        graph.wait_for_publishers("/remap/gossip", "/remap/inside")
        graph.wait_for_publishers("/remap/secret", "/remap/own")

    def test_env_reaches_the_nodes_after_it_or_its_own(self) -> None:
        """Course 001-feature-7."""
        self.assert_nodes("/env", "usual", "short", "own")
        layouts = {
            node: self.launch.graph.environment("/env/" + node).get("ROSCONSOLE_FORMAT")
            for node in ("usual", "short", "own")
        }
        self.assertEqual(layouts["usual"], os.environ.get("ROSCONSOLE_FORMAT"))
        self.assertEqual(layouts["short"], "${node} says: ${message}")
        self.assertEqual(layouts["own"], "${message}")

    def test_rosparam_loads_and_deletes(self) -> None:
        """Course 001-feature-3."""
        self.assert_nodes("/rosparam", "talker")
        self.assertNotIn("/rosparam/rosparam_demo/stale", self.launch.graph.parameters())
        self.launch.graph.wait_for_parameters(
            "/rosparam/talker", {"rate": 5.0, "Message": "I speak at 5.0 Hz"}
        )
        self.launch.graph.wait_for_parameters(
            "/rosparam/rosparam_demo",
            {
                "robot": {"name": "puma", "joints": 6},
                "limits": [-1.5, 1.5],
                "single": 3,
                "from_file/amplitude_scale": 0.25,
                "from_file/keep_positive": False,
            },
        )
        tilt = self.launch.graph.parameter("/rosparam/rosparam_demo/tilt")
        self.assertAlmostEqual(tilt, pi / 6)

    def test_node_args(self) -> None:
        self.assert_nodes("/node_args", "talker")
        self.launch.graph.wait_for_publishers("/node_args/gossip", "/node_args/talker")
        self.assertEqual(self.launch.graph.publishers("/node_args/chatter"), set())
        self.launch.graph.wait_for_parameters(
            "/node_args/talker", {"rate": 5.0, "Message": "said with args"}
        )

    def test_respawn_starts_the_node_again(self) -> None:
        """Course 001-feature-6."""
        self.assert_nodes("/respawn", "talker")
        first = self.launch.processes()["/respawn/talker"]
        self.launch.graph.kill("/respawn/talker")
        self.launch.wait_for_new_process("/respawn/talker", first)
        self.assert_nodes("/respawn", "talker")

    def test_launch_prefix_lowers_the_priority(self) -> None:
        """Course 001-feature-8."""
        self.assert_nodes("/launch_prefix", "talker")
        own = os.getpriority(os.PRIO_PROCESS, 0)
        self.assertEqual(self.launch.graph.niceness("/launch_prefix/talker"), min(own + 5, 19))

    def test_delayed_start_waits_and_becomes_the_node(self) -> None:
        """Course 001-feature-5."""
        waiting = self.at_once["/delayed_start/talker"]
        self.assertEqual(waiting.program, "sh")
        self.assert_nodes("/delayed_start", "listener", "talker")
        now = self.launch.processes()["/delayed_start/talker"]
        self.assertEqual(now, Process("talker.py", waiting.pid))

    def test_machine(self) -> None:
        self.assert_nodes("/machine", "talker", "listener")
        machines = self.launch.machines()
        self.assertEqual(machines["/machine/talker"], "there")
        self.assertEqual(machines["/machine/listener"], "")

    def test_param_types(self) -> None:
        with open(
            os.path.join(launch_file("basic_comms", ".."), "config", "params.yaml"), "rb"
        ) as source:
            content = source.read()
        self.launch.graph.wait_for_parameters(
            "/with_bytes/types",
            {
                "guessed": 1.5,
                "text": "1.5",
                "int": 3,
                "double": 1000.0,
                "bool": True,
                "list": [1, "two", 3.0],
                "textfile": content.decode(),
                "command": "Linux\n",
                "angle": pi / 2,
            },
        )
        get = self.launch.graph.parameter
        self.assertEqual(get("/with_bytes/types/date").value, "20200229T12:30:00")
        self.assertEqual(get("/with_bytes/types/bytes/base64").data, b"hello")
        self.assertEqual(get("/with_bytes/types/bytes/binfile").data, content)

    def test_param_types_leaves_bytes_out_unless_asked(self) -> None:
        self.assertIn("/param_types/types/date", self.launch.graph.parameters())
        self.assertNotIn("/param_types/types/bytes/base64", self.launch.graph.parameters())

    def test_a_bare_date_cannot_be_set(self) -> None:
        with tempfile.NamedTemporaryFile("w", suffix=".launch") as file:
            file.write("<launch><rosparam>{day: 2020-02-29}</rosparam></launch>")
            file.flush()
            with self.assertRaisesRegex(TypeError, "cannot marshal"):
                with launched(file.name):
                    pass

    def test_the_end_of_a_required_node_ends_the_launch(self) -> None:
        """Course 001-feature-6."""
        with launched("basic_comms features/required.launch __ns:=required") as launch:
            talker, listener = "/required/talker", "/required/listener"
            launch.graph.wait_for_nodes(talker, listener, under="/required/")
            launch.graph.kill(listener)
            launch.graph.wait_for_nodes(talker, under="/required/")
            self.assertFalse(launch.ended())
            launch.graph.kill(talker)
            wait_until(launch.ended, lambda: "the launch goes on")
            launch.graph.wait_for_nodes(under="/required/")


if __name__ == "__main__":
    rosrun("basic_comms", "launch_features", LaunchFeatures)
