"""Rig with a publisher of arrays in this process, and subscribers in others."""

import contextlib
import gc
import io
import json
import os
import socket
import subprocess
import sys
import time
import unittest
import xmlrpc.client

import rospy
from helpers.array_subscriber import numbered
from rosgraph.network import encode_ros_handshake_header, read_ros_handshake_header
from std_msgs.msg import UInt8MultiArray

from nodekit.messaging.publisher import Publisher
from nodekit.shared_memory import frame
from nodekit.shared_memory.channel import FIELD, ReaderChannel
from nodekit.testing.waiting import wait_until

HELPERS = os.path.dirname(os.path.realpath(__file__))
TIME_OUT = 30.0  # s
LARGE, SMALL = 1_000_000, 100  # bytes


class Subscriber:
    """A process with a subscriber of arrays, ended with the test."""

    def __init__(self, case, mode, *arguments, environment=None):
        script = os.path.join(HELPERS, "array_subscriber.py")
        self.process = subprocess.Popen(
            [sys.executable, "-W", "error::SyntaxWarning", script, mode, f"topic:={case.topic}"]
            + list(arguments),
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            universal_newlines=True,
        )
        case.addCleanup(self.end)
        self.name = ""

    def tell(self, line=""):
        """Have it do something; return its record."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        lines = iter(self.process.stdout.readline, "")
        return json.loads(next(one for one in lines if one[0] in '{"'))  # the others are logs

    def has(self, number):
        """Tell whether it has a message, the last one."""
        return self.tell()["numbers"][-1:] == [number]

    def end(self):
        """Kill the process."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()


class SharedMemoryCase(unittest.TestCase):
    """Test with a publisher in this process."""

    def setUp(self):
        self.topic = rospy.resolve_name("~" + self.id().rsplit(".", 1)[-1])
        self.count = 0

    def new_publisher(self, **kwds):
        """Return an open publisher of arrays on the test's own topic."""
        publisher = Publisher(self.topic, UInt8MultiArray, **kwds)
        self.addCleanup(publisher.close)
        publisher.open()
        return publisher

    def subscribe(self, publisher, *modes):
        """Start subscribers, and wait until they are connected."""
        before = {one.node for one in publisher.statistics()}
        subscribers = [Subscriber(self, *mode.split()) for mode in modes]
        wait_until(
            lambda: len(publisher.statistics()) == len(before) + len(modes),
            lambda: f"connected: {publisher.statistics()}",
            timeout=TIME_OUT,
        )
        if len(modes) == 1:
            (subscribers[0].name,) = {one.node for one in publisher.statistics()} - before
        return subscribers

    def publish(self, publisher, *sizes, pause=0.0):
        """Publish arrays, with the next numbers."""
        for size in sizes:
            publisher.publish(UInt8MultiArray(data=numbered(self.count, size)))
            self.count += 1
            time.sleep(pause)

    def wait_for_all(self, *subscribers):
        """Wait until subscribers have the last message; return their records."""
        for one in subscribers:
            wait_until(lambda one=one: one.has(self.count - 1), one.tell, timeout=TIME_OUT)
        return [one.tell() for one in subscribers]

    def statistics(self, publisher, subscriber):
        """Return the statistics of a subscriber."""
        return next(one for one in publisher.statistics() if one.node == subscriber.name)

    @staticmethod
    def segments(publisher, is_idle=False):
        """Return the topic's segments, after read ones are collected, and unused ones given up."""
        memory = publisher._topic._memory
        with publisher._topic._lock:
            memory.collect()
            if is_idle:
                memory.pool.trim(1e12)
            return list(memory.pool._segments.values())

    def is_lent(self, publisher):
        """Return whether a subscriber has a segment of a topic, or waits for one."""
        return any(one.users for one in self.segments(publisher))

    def missed(self, subscriber):
        """Return the messages that a subscriber has missed, as its statistics say."""
        uri = rospy.get_master().lookupNode(subscriber.name)[2]
        _, _, (_, topics, _) = xmlrpc.client.ServerProxy(uri).getBusStats("/test")
        return dict(topics)[self.topic][0][3]

    def transports(self, uri=None):
        """Return the sorted transports of the topic's connections, as a node lists them."""
        proxy = xmlrpc.client.ServerProxy(uri or rospy.get_node_uri())
        _, _, connections = proxy.getBusInfo("/test")
        return sorted(one[3] for one in connections if one[4] == self.topic)


class RawSubscriber:
    """A subscriber in this process that leaves its channel and connection to the test.

    :param case: the test
    :param number: identifies it
    """

    def __init__(self, case, number):
        self.channel = ReaderChannel()
        uri = xmlrpc.client.ServerProxy(rospy.get_node_uri())
        _, _, (_, host, port) = uri.requestTopic("/raw", case.topic, [["TCPROS"]])
        self.socket = socket.create_connection((host, port), TIME_OUT)
        case.addCleanup(self.socket.close)
        header = {
            "callerid": f"/raw_{number}",
            "topic": case.topic,
            "type": UInt8MultiArray._type,
            "md5sum": UInt8MultiArray._md5sum,
            FIELD: self.channel.name,
        }
        self.socket.sendall(encode_ros_handshake_header(header))
        read_ros_handshake_header(self.socket, io.BytesIO(), 65536)

    def announced(self):
        """Return the next announcement."""
        data = self.socket.recv(frame.SIZE, socket.MSG_WAITALL)
        return frame.unpack_from(data, 0)

    def read(self):
        """Return the array of the next message, which is given back."""
        one = self.announced()
        array = self.channel.receive(one.segment).read(one.start, one.stop)
        self.channel.give_back(one.segment)
        return array

    def leave(self):
        """Close everything."""
        self.channel = None
        self.socket.close()


def memory_files(pid="self"):
    """Return the number of segments that a process has open, this one by default."""
    gc.collect()
    links = []
    for name in os.listdir(f"/proc/{pid}/fd"):
        with contextlib.suppress(OSError):
            links.append(os.readlink(f"/proc/{pid}/fd/{name}"))
    return sum("memfd:nodekit" in link for link in links)


def mapped(pid):
    """Return the number of segments that a process has mapped.

    :param pid: its id
    """
    with open(f"/proc/{pid}/maps") as file:
        return sum("memfd:nodekit" in line for line in file)
