#!/usr/bin/env python3
"""Hostile clients of a node's ports do not disturb the node and its other clients."""

import random
import socket
import struct
import time
import unittest
from contextlib import ExitStack, contextmanager
from typing import Iterator, List, Tuple

import rosgraph
import rospy
from helpers.machine_lag import Lag, measured_lag
from helpers.process_facts import Usage, listening, usage
from helpers.sample_gaps import gaps
from helpers.tcpros import Tap, address, connect, header
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
from std_srvs.srv import Trigger

from basic_comms.msg import signal_msg
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

#: Most connections that a node lets wait without a header.
MOST_WAITING = 100
NODES = ("/talker", "/listener", "/signal_generator", "/process", "/fleet")
GENERATOR, TOPIC = "/signal_generator", "/signal"
RATE = 1000.0  # Hz
#: Memory that a process may keep after doing something for the first time [bytes].
ALLOWANCE = 3_000_000
#: Longest silence between two samples on a machine that does nothing else, s; the longest that is
#: meant to be is 0.05 s, in which a subscriber is given time to read.
SILENCE = 0.2


class HostilePeers(unittest.TestCase):
    """The generator at 1 kHz, a well-behaved subscriber in this process, and a hostile one."""

    graph: Graph
    uri: str
    where: Tuple[str, int]

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_hostile_peers")
        cls.graph = Graph()
        wait_until(lambda: cls.graph.initialised(*NODES), lambda: str(cls.graph.nodes()))
        cls.uri = rosgraph.Master("/test").lookupNode(GENERATOR)
        cls.where = address(cls.uri)
        # Connections of the other nodes, which would count as left behind by the first test.
        cls.graph.wait_until_heard(GENERATOR, TOPIC, "/process")
        cls.graph.wait_until_heard(GENERATOR, "/rosout", "/rosout")
        MessageRecorder(TOPIC, signal_msg).wait_for(lambda sample: True)
        Tap(cls.uri, TOPIC, signal_msg).close()

    @contextmanager
    def unnoticed(self) -> Iterator[Lag]:
        """Check that the well-behaved subscriber loses nothing meanwhile, and nothing leaks.

        :returns: longest delay by the machine
        """
        pid, talker = self.graph.pid(GENERATOR), self.graph.pid("/talker")
        before = usage(pid)
        arrivals: List[Tuple[float, float]] = []
        with measured_lag(lambda: (pid, talker)) as lag:
            subscriber = rospy.Subscriber(
                TOPIC,
                signal_msg,
                lambda sample: arrivals.append((time.monotonic(), sample.time_x)),
                tcp_nodelay=True,
            )
            self.addCleanup(subscriber.unregister)
            wait_until(lambda: arrivals, lambda: "nothing arrives")
            yield lag
            ended_at = arrivals[-1][1]
            wait_until(lambda: arrivals[-1][1] > ended_at + 0.2, lambda: "nothing arrives any more")
            subscriber.unregister()
        self.assertEqual(gaps([time_x for _, time_x in arrivals], RATE, lag), [])
        gap = longest_gap([moment for moment, _ in arrivals])
        self.assertLess(gap, lag.allowed(SILENCE))
        wait_until(lambda: is_back(usage(pid), before), lambda: f"{usage(pid)}, {before}")
        grown = usage(pid).memory - before.memory
        print(
            f"{self.id()}: longest gap {1000 * gap:.1f} ms, longest delay by the machine "
            f"{1000 * lag.longest:.1f} ms, memory {int(grown // 1000):+} kB"
        )
        self.assertEqual(self.graph.pid(GENERATOR), pid)

    def test_subscriber_that_never_reads(self) -> None:
        talker = rosgraph.Master("/test").lookupNode("/talker")
        log = MessageRecorder("/rosout", Log)
        self.addCleanup(log.close)
        self.graph.wait_until_heard("/talker", "/rosout", rospy.get_name())
        rospy.set_param("/talker/rate", 20.0)  # the master keeps a connection for changes
        log.wait_for(lambda line: line.name == "/talker" and "rate: 10 -> 20" in line.msg)
        heard: List[float] = []
        subscriber = rospy.Subscriber("/chatter", String, lambda _: heard.append(time.monotonic()))
        self.addCleanup(subscriber.unregister)
        wait_until(lambda: heard, lambda: "the talker is silent")
        # The generator would take minutes to fill the buffers of such a connection.
        for name, quick, slow in (("/talker/rate", 2000.0, 10.0), ("/Message", "x" * 3000, "x")):
            self.addCleanup(rospy.set_param, name, slow)
            rospy.set_param(name, quick)
        with ExitStack() as stack:
            lag = stack.enter_context(self.unnoticed())
            idle = stack.enter_context(connect(self.where))
            mute = stack.enter_context(connect(address(talker)))
            idle.sendall(header(TOPIC, signal_msg, callerid="/idle"))
            start = len(heard)
            mute.sendall(header("/chatter", String, callerid="/mute"))
            log.wait_for(lambda line: "subscriber /mute does not keep up" in line.msg)
            count = len(heard) + 1000
            wait_until(lambda: len(heard) > count, lambda: f"heard {len(heard)} of {count}")
            moments = heard[start:]
        # It is the talker's other subscribers whom it could hold up.
        self.assertLess(longest_gap(moments), lag.allowed(SILENCE))

    def test_garbage(self) -> None:
        noise = random.Random(1)
        payloads = [
            *(bytes(noise.getrandbits(8) for _ in range(size)) for size in (1, 4, 100, 5000)),
            b"GET / HTTP/1.0\r\n\r\n",
            b"\0\0\0\0",
            struct.pack("<II", 8, 4) + b"junk",
            struct.pack("<II", 8, 4) + b"a=\xff\xfe",
            struct.pack("<II", 8, 2**32 - 1) + b"junk",
        ]
        with self.unnoticed():
            for payload in payloads:
                with connect(self.where) as peer:
                    peer.sendall(payload)

    def test_wrong_type_is_answered_by_an_error(self) -> None:
        cases = [
            (TOPIC, {"md5sum": "0" * 32}),
            (TOPIC, {"type": "std_msgs/String", "md5sum": String._md5sum}),
            ("/nothing", {}),
            ("", {}),
        ]
        with self.unnoticed():
            for topic, changes in cases:
                with connect(self.where) as peer:
                    peer.sendall(header(topic, signal_msg, **changes))
                    self.assertIn(b"error=", peer.recv(4096), (topic, changes))

    def test_header_of_four_gigabytes(self) -> None:
        with self.unnoticed(), connect(self.where) as peer:
            peer.sendall(struct.pack("<I", 2**32 - 1))
            self.assertEqual(peer.recv(1), b"", "it is not refused before it is read")

    def test_half_a_header(self) -> None:
        with self.unnoticed():
            whole = header(TOPIC, signal_msg)
            for size in (2, 4, 6, len(whole) // 2, len(whole) - 1):
                with connect(self.where) as peer:
                    peer.sendall(whole[:size])

    def test_twenty_subscribers_that_come_and_go(self) -> None:
        dice = random.Random(2)
        peers: List[socket.socket] = []
        with self.unnoticed():
            for _ in range(200):
                if len(peers) < 20 and dice.random() < 0.6:
                    peers.append(connect(self.where))
                    peers[-1].sendall(header(TOPIC, signal_msg))
                elif peers:
                    peer = peers.pop(dice.randrange(len(peers)))
                    if dice.random() < 0.5:  # as a process that is killed with unread data
                        linger = struct.pack("ii", 1, 0)
                        peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
                    peer.close()
            for peer in peers:
                peer.close()

    def test_silent_connections_keep_nobody_waiting(self) -> None:
        half = header(TOPIC, signal_msg)[:7]
        with self.unnoticed(), ExitStack() as stack:
            silent = [stack.enter_context(connect(self.where)) for _ in range(20)]
            for peer in silent[::2]:
                peer.sendall(half)
            tap = Tap(self.uri, TOPIC, signal_msg)
            self.assertEqual(tap.read()._type, signal_msg._type)
            tap.close()
            describe = rospy.ServiceProxy(GENERATOR + "/describe", Trigger)
            self.assertTrue(describe().success)

    def test_of_too_many_silent_connections_the_oldest_is_ended(self) -> None:
        with self.unnoticed(), ExitStack() as stack:
            silent = [stack.enter_context(connect(self.where)) for _ in range(MOST_WAITING)]
            self.assertEqual(silent[0].recv(1), b"")
            Tap(self.uri, TOPIC, signal_msg).close()

    def test_nodes_listen_to_this_machine_only(self) -> None:
        pids = {name: self.graph.pid(name) for name in NODES}
        pids["master"] = rosgraph.Master("/test").getPid()
        for name, pid in pids.items():
            found = listening(pid)
            self.assertTrue(found, name)
            self.assertEqual({host for host, _ in found}, {"127.0.0.1"}, name)


def longest_gap(moments: List[float]) -> float:
    """Return the longest interval between two times [s]."""
    return max(later - one for one, later in zip(moments, moments[1:]))


def is_back(now: Usage, before: Usage) -> bool:
    """Return whether a process has no more resources than before."""
    return (
        now.threads <= before.threads
        and now.descriptors <= before.descriptors
        and now.memory <= before.memory + ALLOWANCE
    )


if __name__ == "__main__":
    rosrun("basic_comms", "hostile_peers", HostilePeers)
