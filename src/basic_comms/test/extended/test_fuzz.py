#!/usr/bin/env python3
"""Hundreds of invalid requests to both ports of every node: all nodes survive unchanged."""

import random
import socket
import unittest
from contextlib import closing
from typing import Any, Dict, List, Tuple
from urllib.parse import urlparse

import rosgraph
from helpers.fuzzing import Fuzzer
from helpers.process_facts import Usage, usage
from helpers.tcpros import Tap, address, connect
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float32, String

from basic_comms.msg import signal_msg
from nodekit.testing.graph import Graph
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

CASES = 400
STREAMS = {
    "/talker": ("/chatter", String),
    "/listener": ("/rosout", Log),
    "/signal_generator": ("/signal", signal_msg),
    "/process": ("/proc_signal", Float32),
    "/fleet": ("/Group1/proc_signal", Float32),
}
#: Services without side effects.
HARMLESS = ("/describe", "/get_loggers")


class Fuzz(unittest.TestCase):
    """Each test takes the nodes in turns."""

    graph: Graph
    uris: Dict[str, str]

    @classmethod
    def setUpClass(cls) -> None:
        cls.graph = Graph()
        wait_until(lambda: cls.graph.initialised(*STREAMS), lambda: str(cls.graph.nodes()))
        cls.uris = {node: rosgraph.Master("/test").lookupNode(node) for node in STREAMS}
        cls.assert_all_speak()
        for node in STREAMS:  # or it would connect during a test, and seem to be left behind
            cls.graph.wait_until_heard(node, "/rosout", "/rosout")
        cls.slow_down()

    @classmethod
    def slow_down(cls) -> None:
        """Set the generator's rate to 50 Hz, as a stream of 1 kHz is costly, and wait for it.

        The master keeps a connection to the node for changes, which is then there for all tests.
        """
        cls.graph.set_parameter("/signal_generator/rate", 50.0)
        with closing(Tap(cls.uris["/signal_generator"], *STREAMS["/signal_generator"])) as tap:
            wait_until(
                lambda: abs(tap.read().time_x - tap.read().time_x) > 0.01,
                lambda: "the signal generator's rate does not change",
            )

    @classmethod
    def assert_all_speak(cls) -> None:
        """Receive a message of each node, which proves that its subscriptions are connected."""
        master = rosgraph.Master("/test")
        for node, (topic, kind) in STREAMS.items():
            wait_until(
                lambda: node in dict(master.getSystemState()[0]).get(topic, ()),
                lambda: f"{node} does not publish {topic}",
            )
            tap = Tap(cls.uris[node], topic, kind)
            tap.read()
            tap.close()

    def setUp(self) -> None:
        self.pids = {node: self.graph.pid(node) for node in STREAMS}
        self.parameters = self.settings()
        self.before = self.usages()
        self.names = [
            *(topic for topic, _ in STREAMS.values()),
            *(node + ending for node in STREAMS for ending in HARMLESS),
            *(name for name in self.graph.parameters() if name.startswith("/signal_generator/")),
        ]

    def settings(self) -> Any:
        return {node: self.graph.parameter(node) for node in STREAMS if node != "/listener"}

    def usages(self) -> Dict[str, Usage]:
        return {node: usage(pid) for node, pid in self.pids.items()}

    def send(self, requests: List[bytes], ports: List[Tuple[str, int]]) -> None:
        """Send each request to one of the ports, and wait for the answers to some."""
        patience = random.Random(3)
        for number, request in enumerate(requests):
            with connect(ports[number % len(ports)]) as peer:
                peer.settimeout(0.1)
                try:
                    peer.sendall(request)
                    if patience.random() < 0.3:
                        peer.recv(65536)
                except (socket.timeout, ConnectionError):
                    pass  # it need not answer

    def assert_unharmed(self) -> None:
        self.assertEqual({node: self.graph.pid(node) for node in STREAMS}, self.pids)
        self.assert_all_speak()
        self.assertEqual(self.settings(), self.parameters)
        wait_until(self.nothing_stays, lambda: f"{self.usages()}, before {self.before}")

    def nothing_stays(self) -> bool:
        """Return whether no connection and no thread remains."""
        now = self.usages()
        return all(
            now[node].threads <= self.before[node].threads
            and now[node].descriptors <= self.before[node].descriptors
            for node in STREAMS
        )

    def test_xmlrpc_port(self) -> None:
        fuzzer = Fuzzer(5, self.names)
        ports = [(str(url.hostname), int(url.port)) for url in map(urlparse, self.uris.values())]
        self.send([fuzzer.http_request() for _ in range(CASES)], ports)
        self.assert_unharmed()

    def test_port_of_topics_and_services(self) -> None:
        fuzzer = Fuzzer(6, self.names)
        ports = [address(uri) for uri in self.uris.values()]
        self.send([fuzzer.tcpros_request() for _ in range(CASES)], ports)
        self.assert_unharmed()


if __name__ == "__main__":
    rosrun("basic_comms", "fuzz", Fuzz)
