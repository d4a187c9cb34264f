#!/usr/bin/env python3
"""A signal ends any node at any time: no hang, exit status 0, no registrations left."""

import os
import signal
import subprocess
import tempfile
import unittest

import rosgraph
import roslib.packages

from nodekit.testing.graph import Graph
from nodekit.testing.running import rosrun
from nodekit.testing.slow_master import SlowMaster
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: Shorter than TIMEOUT_S, for the cases after one that hangs [s].
END_TIMEOUT = 15.0


class Signals(unittest.TestCase):
    """Nodes that get a signal while they start, run, or wait for a master."""

    def setUp(self) -> None:
        self.graph = Graph()
        self.log = tempfile.NamedTemporaryFile()
        self.addCleanup(self.log.close)

    def node(self, program: str, **environment: str) -> "subprocess.Popen[bytes]":
        """Start a node; it is killed at the end of the test if it is still there."""
        self.name = program.partition(".")[0]
        path = roslib.packages.find_node("basic_comms", program)[0]
        process = subprocess.Popen([path], env={**os.environ, **environment}, stderr=self.log)

        def end() -> None:
            process.kill()
            process.wait()

        self.addCleanup(end)
        return process

    def logged(self) -> bytes:
        """Return the stderr output of this test's nodes so far."""
        with open(self.log.name, "rb") as log:
            return log.read()

    def assert_ended(self, process: "subprocess.Popen[bytes]") -> None:
        self.assertEqual(process.wait(END_TIMEOUT), 0)
        self.assertEqual(self.graph.nodes(), set())
        with self.assertRaises(rosgraph.MasterError):  # parameters that it subscribed to count too
            rosgraph.Master("/test").lookupNode("/" + self.name)

    def test_at_the_end_of_init_node(self) -> None:
        self.interrupt_registration("listener.py", "registerService", "/set_logger_level")

    def test_while_a_publisher_is_registered(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            self.interrupt_registration("talker.py", "registerPublisher", "/chatter", number=number)

    def test_while_a_subscriber_is_registered(self) -> None:
        self.interrupt_registration("listener.py", "registerSubscriber", "/chatter")

    def test_while_a_service_is_registered(self) -> None:
        self.interrupt_registration("signal_generator.py", "registerService", "/enable")

    # Registrations that the master processes after the node's cleanup are removed as well.

    def test_while_the_first_parameter_is_subscribed(self) -> None:
        self.interrupt_registration("process.py", "subscribeParam", "/process", "unregisterService")

    def test_while_a_member_of_a_fleet_subscribes_its_parameters(self) -> None:
        member = "/Group1/process"
        self.interrupt_registration("fleet", "subscribeParam", member, "unsubscribeParam")

    def test_while_a_fleet_reads_its_parameters(self) -> None:
        self.interrupt_registration("fleet", "getParam", "/Group1/process", "unregisterPublisher")

    def interrupt_registration(
        self, program: str, method: str, ending: str, then: str = "", number: int = signal.SIGINT
    ) -> None:
        """Send a signal while the master keeps a node waiting in one call.

        :param then: call of the node's shutdown before that call is answered, if any
        :param number: the signal
        """
        master = SlowMaster(os.environ["ROS_MASTER_URI"], method, ending)
        self.addCleanup(master.close)
        process = self.node(program, ROS_MASTER_URI=master.uri)
        self.assertTrue(master.reached.wait(TIMEOUT_S))
        process.send_signal(number)
        wait_until(lambda: taken_in(process.pid, number), lambda: "the signal is still pending")
        wait_until(lambda: not then or then in master.calls, lambda: str(master.calls))
        master.go_on.set()
        self.assert_ended(process)

    def test_hangup_while_a_node_runs(self) -> None:
        process = self.node("process.py")
        self.graph.wait_for_subscribers("/signal", "/process")
        process.send_signal(signal.SIGHUP)
        self.assert_ended(process)

    def ends_while_it_waits_for_a_master(self, number: int) -> None:
        process = self.node("talker.py", ROS_MASTER_URI="http://localhost:1")
        wait_until(
            lambda: b"waiting for the master" in self.logged(), lambda: f"log: {self.logged()!r}"
        )
        process.send_signal(number)
        self.assert_ended(process)

    def test_interrupt_while_a_node_waits_for_a_master(self) -> None:
        self.ends_while_it_waits_for_a_master(signal.SIGINT)

    def test_termination_while_a_node_waits_for_a_master(self) -> None:
        self.ends_while_it_waits_for_a_master(signal.SIGTERM)


def taken_in(pid: int, number: int) -> bool:
    """Return whether a signal sent to a process is no longer pending."""
    with open(f"/proc/{pid}/status") as status:
        lines = dict(line.split(":", 1) for line in status if ":" in line)
    pending = int(lines["ShdPnd"], 16)
    return not pending & (1 << (number - 1))


if __name__ == "__main__":
    rosrun("basic_comms", "signals", Signals)
