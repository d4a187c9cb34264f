#!/usr/bin/env python3
"""Each file of launch/features does what its comment tells a student."""

import os
import subprocess
import tempfile
import unittest
from math import pi
from typing import Any, ContextManager

import rosgraph
import rospkg
import rostest
from helpers.launching import Launched, launch_file, launched
from helpers.waiting import wait_until


def feature(name: str, *arguments: str) -> ContextManager[Launched]:
    """Start one file of launch/features."""
    return launched(launch_file("features/%s.launch" % name), *arguments)


class LaunchFeatures(unittest.TestCase):
    """One test per file, more where a file can go two ways."""

    def assert_parameters(self, launch: Launched, **expected: Any) -> None:
        """Compare parameters; in their names here, __ stands for a slash."""
        for name, value in expected.items():
            path = "/" + name.replace("__", "/")
            self.assertEqual(launch.graph.parameter(path), value, path)

    def test_group_ns(self) -> None:
        with feature("group_ns") as launch:
            launch.graph.wait_for_nodes(
                "/left/talker", "/left/inner/talker", "/far/talker", "/right/listener"
            )
            launch.graph.wait_for_publishers("/left/chatter", "/left/talker")
            launch.graph.wait_for_publishers("/left/inner/chatter", "/left/inner/talker")
            launch.graph.wait_for_publishers("/far/chatter", "/far/talker")
            launch.graph.wait_for_subscribers("/right/chatter", "/right/listener")

    def test_remap_reaches_as_far_as_its_group(self) -> None:
        with feature("remap") as launch:
            launch.graph.wait_for_nodes("/before", "/inside", "/own", "/after")
            launch.graph.wait_for_publishers("/chatter", "/before", "/after")
            launch.graph.wait_for_publishers("/gossip", "/inside")
            launch.graph.wait_for_publishers("/secret", "/own")

    def test_env_reaches_the_nodes_after_it_or_its_own(self) -> None:
        with feature("env") as launch:
            launch.graph.wait_for_nodes("/usual", "/short", "/own")
            layouts = {
                node: launch.graph.environment(node).get("ROSCONSOLE_FORMAT")
                for node in ("/usual", "/short", "/own")
            }
        self.assertEqual(layouts["/usual"], os.environ.get("ROSCONSOLE_FORMAT"))
        self.assertEqual(layouts["/short"], "${node} says: ${message}")
        self.assertEqual(layouts["/own"], "${message}")

    def test_substitution(self) -> None:
        with feature("substitution", "rate:=3.0") as launch:
            wait_until(launch.graph.nodes, lambda: "there is no node at all")
            (node,) = launch.graph.nodes()
            self.assertRegex(node, "^/talker_.*[0-9]$")
            self.assert_parameters(
                launch,
                substitution__env=os.environ["ROS_MASTER_URI"],
                substitution__optenv=os.environ.get("ROBOT_NAME", "no name"),
                substitution__find=rospkg.RosPack().get_path("basic_comms"),
                substitution__dirname=os.path.dirname(launch_file("features/any")),
                substitution__arg="at 3.0 Hz",
                substitution__eval=1.5,
                substitution__anon=node[1:],
            )

    def test_if_and_unless_by_default(self) -> None:
        with feature("if_unless") as launch:
            launch.graph.wait_for_nodes("/talker", "/listener")
            self.assert_parameters(launch, talker__Message="what a day")

    def test_if_and_unless_the_other_way(self) -> None:
        with feature("if_unless", "listen:=false", "mood:=bad") as launch:
            launch.graph.wait_for_nodes("/talker")
            self.assert_parameters(launch, talker__Message="go away")
        with feature("if_unless", "quiet:=true") as launch:
            launch.graph.wait_for_nodes("/listener")
            self.assertNotIn("/talker/Message", launch.graph.parameters())

    def test_arg(self) -> None:
        with feature("arg", "text:=hello") as launch:
            launch.graph.wait_for_nodes("/arg_talker")
            self.assert_parameters(launch, arg_talker__Message="hello", arg_talker__rate=2.0)

    def test_include_hands_on_what_it_is_told_to(self) -> None:
        with feature("include", "rate:=3.0") as launch:
            launch.graph.wait_for_nodes("/defaults/talker", "/one_by_one/talker", "/all/talker")
            self.assert_parameters(
                launch,
                defaults__talker__rate=10.0,
                one_by_one__talker__rate=6.0,
                all__talker__rate=3.0,
            )

    def test_rosparam_loads_and_deletes(self) -> None:
        rosgraph.Master("/test").setParam("/rosparam_demo/stale", 1)
        with feature("rosparam", "rate:=5.0") as launch:
            launch.graph.wait_for_nodes("/talker")
            self.assertNotIn("/rosparam_demo/stale", launch.graph.parameters())
            self.assert_parameters(
                launch,
                rosparam_demo__robot={"name": "puma", "joints": 6},
                rosparam_demo__limits=[-1.5, 1.5],
                rosparam_demo__single=3,
                rosparam_demo__from_file__amplitude_scale=0.25,
                rosparam_demo__from_file__keep_positive=False,
                talker__rate=5.0,
                talker__Message="I speak at 5.0 Hz",
            )
            tilt = launch.graph.parameter("/rosparam_demo/tilt")
            self.assertAlmostEqual(tilt, pi / 6)

    def test_last_setting_wins(self) -> None:
        with feature("last_setting_wins") as launch:
            launch.graph.wait_for_nodes("/signal_generator")
            self.assert_parameters(
                launch,
                signal_generator__amplitude=5.0,
                signal_generator__rate=20.0,
                signal_generator__offset=0.0,
            )

    def test_node_args(self) -> None:
        with feature("node_args") as launch:
            launch.graph.wait_for_publishers("/gossip", "/talker")
            self.assertEqual(launch.graph.publishers("/chatter"), set())
            self.assert_parameters(launch, talker__rate=5.0, talker__Message="said with args")

    def test_respawn_starts_the_node_again(self) -> None:
        with feature("respawn", "delay:=0.2") as launch:
            launch.graph.wait_for_nodes("/talker")
            first = launch.processes()["talker.py"]
            launch.graph.kill("/talker")
            launch.wait_for_new_process("talker.py", first)
            launch.graph.wait_for_nodes("/talker")

    def test_the_end_of_a_required_node_ends_the_launch(self) -> None:
        with feature("required") as launch:
            launch.graph.wait_for_nodes("/talker", "/listener")
            launch.graph.kill("/listener")
            launch.graph.wait_for_nodes("/talker")
            self.assertFalse(launch.ended())
        with feature("required") as launch:
            launch.graph.wait_for_nodes("/talker", "/listener")
            launch.graph.kill("/talker")
            wait_until(launch.ended, lambda: "the launch goes on")
            launch.graph.wait_for_nodes()

    def test_launch_prefix_lowers_the_priority(self) -> None:
        with feature("launch_prefix") as launch:
            launch.graph.wait_for_nodes("/talker")
            own = os.getpriority(os.PRIO_PROCESS, 0)
            self.assertEqual(launch.graph.niceness("/talker"), min(own + 5, 19))

    def test_delayed_start_waits_and_becomes_the_node(self) -> None:
        with feature("delayed_start", "delay:=1") as launch:
            waiting = launch.processes()["sh"]
            launch.graph.wait_for_nodes("/listener", "/talker")
            self.assertEqual(launch.processes()["talker.py"], waiting)
            self.assertNotIn("sh", launch.processes())

    def test_machine(self) -> None:
        with feature("machine") as launch:
            launch.graph.wait_for_nodes("/talker", "/listener")
            self.assertEqual(launch.machines(), {"/talker": "there", "/listener": ""})

    def test_param_types(self) -> None:
        with feature("param_types", "bytes:=true") as launch:
            self.assert_parameters(
                launch,
                types__guessed=1.5,
                types__text="1.5",
                types__int=3,
                types__double=1000.0,
                types__bool=True,
                types__list=[1, "two", 3.0],
                types__command="Linux\n",
                types__angle=pi / 2,
            )
            date = launch.graph.parameter("/types/date")
            self.assertEqual(date.value, "20200229T12:30:00")
            self.assertEqual(launch.graph.parameter("/types/bytes/base64").data, b"hello")
            with open(os.path.join(launch_file(".."), "config", "params.yaml"), "rb") as source:
                content = source.read()
            self.assertEqual(launch.graph.parameter("/types/bytes/binfile").data, content)
            self.assertEqual(launch.graph.parameter("/types/textfile"), content.decode())

    def test_param_types_leaves_bytes_out_unless_asked(self) -> None:
        with feature("param_types") as launch:
            self.assertIn("/types/date", launch.graph.parameters())
            self.assertNotIn("/types/bytes/base64", launch.graph.parameters())

    def test_a_bare_date_cannot_be_set(self) -> None:
        with tempfile.NamedTemporaryFile("w", suffix=".launch") as file:
            file.write("<launch><rosparam>{day: 2020-02-29}</rosparam></launch>")
            file.flush()
            with self.assertRaisesRegex(TypeError, "cannot marshal"):
                with launched(file.name):
                    pass

    def test_self_test_passes_under_rostest(self) -> None:
        with tempfile.TemporaryDirectory() as results:
            command = ["rostest", "--results-base-dir", results]
            command.append(launch_file("features/self_test.launch"))
            ended = subprocess.run(command, stdout=subprocess.PIPE, timeout=120)
        self.assertEqual(ended.returncode, 0, ended.stdout.decode())
        self.assertIn("TESTS: 1", ended.stdout.decode())


if __name__ == "__main__":
    rostest.rosrun("basic_comms", "launch_features", LaunchFeatures)
