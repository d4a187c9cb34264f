#!/usr/bin/env python3
"""Tests of a node with an unknown version of rospy."""

import os
import pathlib
import re
import shutil
import tempfile
import unittest
from typing import List

import rospy
from helpers import echo_node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from nodekit import call_service
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process, Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: Names that differ in the made-up version: all private ones that nodekit uses.
RENAMED = {
    r"\b_PublisherImpl\b": "_PublisherCore",
    r"\b_SubscriberImpl\b": "_SubscriberCore",
    r"\b_client_shutdown_hooks\b": "_hooks_of_clients",
    r"\b_rosout\b": "_to_rosout",
    r"\breceive_callback\b": "receive",
    r"\breceive_once\b": "receive_some",
    r"\b_connect_topic_thread\b": "_connect_one",
    r"\bpublock\b": "publishing",
    r"\binbound_handler\b": "handler",
    r"\b_tcp_server_callback\b": "_on_connection",
    r"\blisteners\b": "observers",
    r"\bdef update\(self, key, value\)": "def renew(self, key, value)",
    r"\bget_param_server_cache\(\)\.update\b": "get_param_server_cache().renew",
}
#: Warnings about it, each once.
SAID = [
    "a silent connection delays others",
    "lines with invalid bytes do not reach /rosout",
    "nodes end after the functions of rospy.on_shutdown",
    "changes are noticed once a second only",
    "topics and services are registered one by one",
    "publishing with queues",
    "receiving one by one",
]


def make_up(folder: pathlib.Path) -> List[str]:
    """Copy this machine's rospy, with other private names.

    :returns: of these names, those that it did not have
    """
    shutil.copytree(str(pathlib.Path(rospy.__file__).parent), str(folder / "rospy"))
    missing = set(RENAMED)
    for file in (folder / "rospy").rglob("*.py"):
        text = file.read_text("utf-8")
        for name, other in RENAMED.items():
            text, count = re.subn(name, other, text)
            if count:
                missing.discard(name)
        file.write_text(text, "utf-8")
    return sorted(missing)


class UnknownRospy(unittest.TestCase):
    """It does all that it does with a known one."""

    def setUp(self) -> None:
        folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, str(folder))
        self.assertEqual(make_up(folder), [])
        path = f"{folder}:{os.environ['PYTHONPATH']}"
        self.node = Process(echo_node.__file__, environment={"PYTHONPATH": path})
        self.addCleanup(self.node.end)

    def recorder(self, topic: str) -> MessageRecorder:
        """Return what hears a topic until the end."""
        recorder = MessageRecorder(topic, String)
        self.addCleanup(recorder.close)
        return recorder

    def answer(self) -> str:
        """Return the gain from its service."""
        return str(call_service("/echo/ask", Trigger, timeout=TIMEOUT_S).result().message)

    def test_without_the_fast_path_it_is_slower_and_logs_it_once(self) -> None:
        server, ticks = Server(), self.recorder("/ticks")
        ticks.wait_for(lambda message: message.data == "tick")
        question = rospy.Publisher("/in", String, queue_size=10, latch=True)
        self.addCleanup(question.unregister)
        question.publish("gain ")
        ticks.wait_for(lambda message: message.data == "own gain 1.0")
        late = self.recorder("/out")
        late.wait_for(lambda message: message.data == "gain 1.0")
        self.assertEqual(self.answer(), "1.0")
        server.set("/echo/gain", 2.5)
        wait_until(lambda: self.answer() == "2.5", self.answer)
        server.set("/echo/gain", -1)
        server.wait_for("/echo/gain", 2.5)
        question.publish("then ")
        late.wait_for(lambda message: message.data == "then 2.5")
        self.assertEqual(self.node.interrupt(), 0)
        late.wait_for(lambda message: message.data == "farewell")
        wait_until(lambda: not server.knows("/echo"), lambda: "it is still registered")
        for what in SAID:
            self.assertEqual(len(self.node.logged("unsupported rospy version", what)), 1, what)
        self.assertEqual(len(self.node.logged("unsupported rospy version")), len(SAID))
        self.assertEqual(self.node.logged("Traceback"), [])


if __name__ == "__main__":
    rospy.init_node("test_unknown_rospy")
    rosrun("nodekit", "unknown_rospy", UnknownRospy)
