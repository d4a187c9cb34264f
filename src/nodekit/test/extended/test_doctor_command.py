#!/usr/bin/env python3
"""Tests of ``rosrun nodekit doctor`` with a healthy system, and with many faults."""

import contextlib
import os
import subprocess
import sys
import tempfile
import unittest
from typing import List, Tuple

import rospkg
from nodekit.master import MasterClient
from nodekit.testing.processes import Master, Process, free_port, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

HELPERS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "helpers")
DOCTOR = os.path.join(rospkg.RosPack().get_path("nodekit"), "scripts", "doctor")
TEXT, NUMBER, STAMPED = "std_msgs/String", "std_msgs/Float64", "std_msgs/Header"
PACKAGE = "<package><name>arm</name></package>"
LAUNCH = """
<launch>
  <arg name="type" default="1" doc=""/>
  <node pkg="nodekit" type="plain_node.py" name="launched" args="launched"/>
</launch>
"""


class WithAMaster(unittest.TestCase):
    """Each test has its own master, and a folder outside of a workspace."""

    def setUp(self) -> None:
        self.closing = contextlib.ExitStack()
        self.addCleanup(self.closing.close)
        master = Master()
        self.closing.callback(master.kill)
        self.environment = {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost"}
        self.master = self.closing.enter_context(MasterClient("/test", master_uri=master.uri))
        self.folder = self.closing.enter_context(tempfile.TemporaryDirectory())

    def start(self, name: str, *topics: str) -> Process:
        """Start a node, and wait until it is registered for all of its topics.

        :param topics: a sign, a topic and its type: ``+`` to publish it, ``-`` to subscribe
        """
        words = " ".join(topics).split()
        script = os.path.join(HELPERS, "plain_node.py")
        process = Process(script, [name, *words], self.environment)
        self.closing.callback(process.end)

        def is_registered() -> bool:
            state = self.master.system_state()
            sides = {"+": dict(state.publishers), "-": dict(state.subscribers)}
            pairs = zip(words[::3], words[1::3])
            return all(f"/{name}" in sides[sign].get(topic, []) for sign, topic in pairs)

        wait_until(is_registered, lambda: f"{name}: {process.error_lines}")
        return process

    def examine(self, **environment: str) -> Tuple[int, List[str]]:
        """Return the exit status and the lines of the command."""
        variables = {**os.environ, **self.environment, **environment}
        done = subprocess.run(
            [sys.executable, DOCTOR],
            cwd=self.folder,
            env={name: value for name, value in variables.items() if value},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            timeout=4.0 * TIMEOUT_S,  # a hang guard: resolvers may take long for an unknown name
        )
        self.assertEqual(done.stderr, "")
        return done.returncode, done.stdout.splitlines()

    def assert_named(self, lines: List[str], *words: str) -> None:
        """Fail unless one fault has all these words."""
        found = [line for line in lines if line.startswith("fault ")]
        matching = [line for line in found if all(word in line for word in words)]
        self.assertEqual(len(matching), 1, f"{words} in {found}")

    def test_healthy_system_is_reported_and_nothing_stays_registered(self) -> None:
        self.start("talker", f"+ /chatter {TEXT}", f"+ /stamped {STAMPED}")
        self.start("listener", f"- /chatter {TEXT}", f"- /stamped {STAMPED}", f"- /x {TEXT}")
        before = self.master.system_state()
        status, lines = self.examine()
        self.assertEqual((status, lines[-1]), (0, "healthy"), lines)
        self.assertIn("note  /x: /listener subscribes, and no node publishes", lines)
        self.assertTrue(any(line.startswith("ok    connections: 2 ") for line in lines), lines)
        self.assertTrue(any("of user " in line for line in lines), lines)
        self.assertEqual(self.master.system_state(), before)

    def test_each_of_many_faults_is_named(self) -> None:
        self.start(
            "one",
            f"+ /mixed {TEXT}",
            f"+ /robot/speed {NUMBER}",
            f"+ /drifted {TEXT}",
            f"+ /stamped {STAMPED}",
        )
        self.start(
            "two",
            f"- /mixed {NUMBER}",
            f"- /speed {NUMBER}",
            f"- /drifted {TEXT}",
            f"- /stamped {STAMPED}",
        )
        self.start("ended", f"+ /left {TEXT}").end()
        stopped = self.start("stopped", f"+ /silent {TEXT}")
        self.master.request([("registerPublisher", "/far", TEXT, "http://no-such-host.invalid:1/")])
        self.master.write({"/use_sim_time": True})
        self.make_workspace()
        self.launch("typo:=1")
        with hanging(stopped.popen.pid):
            status, lines = self.examine()
        self.assertEqual(status, 1)
        self.assert_named(lines, "/mixed: has several types", TEXT, NUMBER)
        self.assert_named(lines, "/speed", "/one publishes /robot/speed")
        self.assert_named(lines, "/drifted: different definitions of std_msgs/String", "0" * 32)
        self.assert_named(lines, "/drifted: /two is not connected to /one")
        self.assert_named(lines, "/ended: ", "nothing listens at", "rosnode cleanup")
        self.assert_named(lines, "/stopped: does not answer", "resume it if it is stopped")
        self.assert_named(lines, "/test: ", "'no-such-host.invalid' is unknown", "/etc/hosts")
        self.assert_named(lines, "/clock: /use_sim_time is true, and no node publishes")
        self.assert_named(lines, "roslaunch ignores the argument typo", "did you mean type?")
        self.assert_named(lines, f"{self.folder}: not built (arm)", "catkin_make")
        self.assertEqual(lines[-1], "10 faults", lines)

    def make_workspace(self) -> None:
        """Make the folder a workspace with a package that is not built."""
        os.makedirs(os.path.join(self.folder, "src", "arm"))
        for path, text in (".catkin_workspace", ""), ("src/arm/package.xml", PACKAGE):
            with open(os.path.join(self.folder, path), "w") as file:
                file.write(text)

    def launch(self, *arguments: str) -> None:
        """Run roslaunch with arguments, and wait for the node that it starts."""
        path = os.path.join(self.folder, "some.launch")
        with open(path, "w") as file:
            file.write(LAUNCH)
        process = subprocess.Popen(
            ["roslaunch", path, *arguments],
            env={**os.environ, **self.environment},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.closing.callback(process.wait)
        self.closing.callback(process.terminate)
        wait_until(lambda: self.master.lookup_node("/launched"), lambda: "no node of roslaunch")

    def test_addresses_that_are_wrong_are_named_without_a_master(self) -> None:
        uri = f"localhost:{free_port()}"
        status, lines = self.examine(ROS_MASTER_URI=uri, ROS_HOSTNAME="", ROS_IP="192.0.2.77")
        self.assertEqual(status, 1)
        self.assert_named(lines, "master: ", f"set it to http://{uri}")
        self.assert_named(lines, "own address: ROS_IP '192.0.2.77'", "set ROS_IP to an address of")
        status, lines = self.examine(ROS_MASTER_URI=f"http://{uri}")
        self.assert_named(lines, "master: no answer at", "start one with roscore")


if __name__ == "__main__":
    rosrun("nodekit", "doctor", WithAMaster)
