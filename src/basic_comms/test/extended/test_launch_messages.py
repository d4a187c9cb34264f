#!/usr/bin/env python3
"""Messages of the talkers: each scope of Message, and changes while they run."""

import subprocess
import unittest
from typing import Dict, List

import rospy
from std_msgs.msg import String

from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.running import rosrun

SCOPES = ("closest", "global", "local", "private")
GLOBAL, LOCAL = "/Message", "/lab/Message"
TEXTS = {GLOBAL: "global text", LOCAL: "local text"}
TEXTS.update({f"/lab/{scope}/Message": "private text" for scope in SCOPES})


def rosparam(*arguments: str) -> List[str]:
    """Run the rosparam command and return the lines it prints."""
    command = ["rosparam", *arguments]
    return subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode().splitlines()


class LaunchMessages(unittest.TestCase):
    """Four talkers that differ in message_scope only, and the texts at each level."""

    graph: Graph
    recorders: Dict[str, MessageRecorder]

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("launch_messages")
        cls.graph = Graph()
        cls.recorders = {scope: MessageRecorder("/lab/heard/" + scope, String) for scope in SCOPES}

    def setUp(self) -> None:
        for name, text in TEXTS.items():
            self.graph.set_parameter(name, text)

    def tearDown(self) -> None:
        for name in set(TEXTS) & self.graph.parameters():
            self.graph.delete_parameter(name)

    def assert_says(self, scope: str, text: str) -> None:
        """Wait until a talker says a text, followed by the time, from now on."""
        self.recorders[scope].clear()
        message = self.recorders[scope].wait_for(lambda heard: heard.data.startswith(text + " "))
        self.assertRegex(message.data[len(text) :], r"^ \d+\.\d+$")

    def test_each_scope_finds_its_text(self) -> None:
        self.assert_says("global", "global text")
        self.assert_says("local", "local text")
        self.assert_says("private", "private text")
        self.assert_says("closest", "private text")

    def test_the_number_after_the_text_is_the_ros_time(self) -> None:
        def number(message: String) -> float:
            return float(message.data.split()[-1])

        before = rospy.get_time()
        message = self.recorders["global"].wait_for(lambda heard: number(heard) >= before)
        self.assertLessEqual(number(message), rospy.get_time())

    def test_closest_walks_outwards_as_texts_are_deleted(self) -> None:
        self.assert_says("closest", "private text")
        self.graph.delete_parameter("/lab/closest/Message")
        self.assert_says("closest", "local text")
        self.graph.delete_parameter(LOCAL)
        self.assert_says("closest", "global text")
        self.graph.delete_parameter(GLOBAL)
        self.assert_says("closest", "hello world")
        self.graph.set_parameter(LOCAL, "back again")
        self.assert_says("closest", "back again")

    def test_an_explicit_scope_says_so_when_its_text_is_missing(self) -> None:
        for name in TEXTS:
            self.graph.delete_parameter(name)
        for scope in ("global", "local", "private"):
            self.assert_says(scope, "No Parameter Found")

    def test_changed_text_shows_at_every_level(self) -> None:
        self.graph.set_parameter(GLOBAL, "new global")
        self.assert_says("global", "new global")
        self.graph.set_parameter(LOCAL, "new local")
        self.assert_says("local", "new local")
        self.graph.set_parameter("/lab/private/Message", 42)
        self.assert_says("private", "42")
        self.assert_says("closest", "private text")

    def test_rosparam_gets_and_lists_what_was_set_as_it_was_set(self) -> None:
        rosparam("set", "/lab/private/Message", "as it is")
        self.assert_says("private", "as it is")
        self.assertEqual(rosparam("get", "/lab/private/Message"), ["as it is"])
        self.assertEqual(rosparam("get", "/lab/private/rate"), ["20.0"])
        self.assertLessEqual(set(TEXTS), set(rosparam("list")))
        rosparam("delete", "/lab/private/Message")
        self.assertNotIn("/lab/private/Message", rosparam("list", "/lab"))

    def test_message_scope_can_be_changed_while_it_talks(self) -> None:
        self.graph.set_parameter("/lab/closest/message_scope", "global")
        self.assert_says("closest", "global text")
        self.graph.set_parameter("/lab/closest/message_scope", "closest")
        self.assert_says("closest", "private text")

    def test_a_parameter_outlives_its_node(self) -> None:
        with launched("basic_comms talker_listener.launch prefix:=outlive") as launch:
            launch.graph.wait_for_nodes("/outlive/talker", "/outlive/listener", under="/outlive/")
            launch.graph.set_parameter("/outlive/talker/Message", "still here")
            launch.graph.kill("/outlive/talker")
            launch.graph.wait_for_nodes("/outlive/listener", under="/outlive/")
            self.assertEqual(launch.graph.parameter("/outlive/talker/Message"), "still here")
            self.assertEqual(launch.graph.parameter("/outlive/talker/rate"), 10.0)

    def test_a_node_that_starts_again_finds_what_was_set_before(self) -> None:
        recorder = MessageRecorder("/again/chatter", String)
        with launched("basic_comms features/respawn.launch __ns:=again delay:=0.1") as launch:
            # Written by the node: a value that it may yet write over is put back, but only by a
            # node that lives, and this one is ended at once.
            launch.graph.wait_for_parameters("/again/talker", {"rate": 10.0})
            launch.graph.set_parameter("/again/talker/rate", 25.0)
            launch.graph.set_parameter("/again/Message", "from the first life")
            self.addCleanup(self.graph.delete_parameter, "/again/Message")
            first = launch.processes()["/again/talker"]
            launch.graph.kill("/again/talker")
            launch.wait_for_new_process("/again/talker", first)
            launch.graph.wait_for_nodes("/again/talker", under="/again/")
            recorder.clear()
            recorder.wait_for(lambda heard: heard.data.startswith("from the first life "))
            self.assertEqual(launch.graph.parameter("/again/talker/rate"), 25.0)
        recorder.close()


if __name__ == "__main__":
    rosrun("basic_comms", "launch_messages", LaunchMessages)
