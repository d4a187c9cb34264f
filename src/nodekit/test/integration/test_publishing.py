#!/usr/bin/env python3
"""Tests of publishing to real nodes that are stopped, killed, late, or never read."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest
import xmlrpc.client
from unittest import mock

import rosgraph
import rosnode
import rospy
from helpers.recording_subscriber import numbered
from rosgraph.network import encode_ros_handshake_header
from std_msgs.msg import String

from nodekit.messaging.publisher import Publisher
from nodekit.rospy_internals import outgoing_topic
from nodekit.testing.processes import hanging
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import wait_until
from nodekit.transport import delivery, subscriber_connection

HELPERS = os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "helpers")

TIME_OUT = 30.0  # s
SIZE = 16_000  # characters; a socket's buffers are full after some hundred messages
RATE = 1000.0  # Hz


def memory():
    """Tell how much memory this process holds.

    :returns: resident set, bytes
    """
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Node:
    """A process of a helper, ended with the test."""

    def __init__(self, case, script, topic):
        self.process = subprocess.Popen(
            [sys.executable, "-W", "error::SyntaxWarning", os.path.join(HELPERS, script)]
            + [f"topic:={topic}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )
        case.addCleanup(self.end)

    def record(self):
        """Return the record of a recording subscriber.

        :returns: its record
        """
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def end(self):
        """Kill the process."""
        self.process.kill()
        self.process.communicate()


class PublishingTest(unittest.TestCase):
    """A publisher in this process, its subscribers in others."""

    def setUp(self):
        self.topic = rospy.resolve_name("~" + self.id().rsplit(".", 1)[-1])
        self.count = 0
        # A busy machine may hold up a subscriber that is to miss nothing.
        patience = mock.patch.object(delivery, "PATIENCE_S", 2.0)
        patience.start()
        self.addCleanup(patience.stop)

    def publisher(self, **kwds):
        """Make an open publisher of strings on the test's own topic.

        :returns: the publisher
        """
        publisher = Publisher(self.topic, String, **kwds)
        self.addCleanup(publisher.close)
        publisher.open()
        return publisher

    def subscriber(self, publisher):
        """Start a recording subscriber.

        :returns: its name and process
        """
        before = {s.node for s in publisher.statistics()}
        node = Node(self, "recording_subscriber.py", self.topic)
        wait_until(
            lambda: len(publisher.statistics()) > len(before), lambda: "it is not subscribed"
        )
        (name,) = {s.node for s in publisher.statistics()} - before
        return name, node

    def publish(self, publisher, number, until=lambda: False):
        """Publish at 1 kHz.

        :param number: how many messages at most
        :param until: function that ends it
        """
        start, first = time.monotonic(), self.count
        while self.count < first + number and not until():
            publisher.publish(String(numbered("a", self.count, SIZE)))
            self.count += 1
            pause = start + (self.count - first) / RATE - time.monotonic()
            if pause > 0:
                time.sleep(pause)

    def publish_until_stalled(self, publisher, name):
        """Publish until the buffers of a hanging subscriber are full."""
        self.publish(publisher, 20_000, until=lambda: self.statistics_of(publisher, name).stalled)

    def wait_for(self, node, condition, what):
        """Wait until the record of a subscriber is as expected.

        :returns: the record
        """
        record = node.record()
        deadline = time.monotonic() + TIME_OUT
        while not condition(record):
            self.assertLess(time.monotonic(), deadline, f"waited in vain until {what}")
            time.sleep(0.02)
            record = node.record()
        return record

    def last(self, number):
        """Make a condition: the last message with a number has arrived."""
        return lambda record: record["numbers"].get("a", [None])[-1] == number

    def statistics_of(self, publisher, name):
        """Tell how one subscriber fares."""
        return next(s for s in publisher.statistics() if s.node == name)

    def no_more_threads(self):
        """Tell whether the publisher's own threads are gone."""
        return not any(t.name == "drain" for t in threading.enumerate())

    def test_stopped_subscriber_delays_no_other_and_recovers(self):
        publisher = self.publisher()
        _, good = self.subscriber(publisher)
        name, stopped = self.subscriber(publisher)
        self.publish(publisher, 200)
        with hanging(stopped.process.pid):
            self.publish_until_stalled(publisher, name)
            self.assertTrue(self.statistics_of(publisher, name).stalled)
            held = memory()
            self.publish(publisher, 1000)
            grown = memory() - held
            self.assertLess(grown, 8_000_000, "16 MB were published meanwhile")
            lost = self.statistics_of(publisher, name).lost
            self.assertGreaterEqual(lost, 900)
        wait_until(
            lambda: not self.statistics_of(publisher, name).stalled, lambda: "it is still stalled"
        )
        # Until it has received the messages held during its hang, it is not waited for.
        self.wait_for(stopped, self.last(self.count - 1), "the stopped one has caught up")
        back_at = self.count
        self.publish(publisher, 200)
        record = self.wait_for(good, self.last(self.count - 1), "all has arrived")
        self.assertEqual(record["numbers"]["a"], list(range(self.count)))
        print(f"longest gap seen by the good subscriber: {1000 * record['longest_gap']:.1f} ms")
        record = self.wait_for(stopped, self.last(self.count - 1), "the stopped one is back")
        self.assertEqual(record["torn"], 0)
        numbers = record["numbers"]["a"]
        self.assertEqual(numbers, sorted(set(numbers)))
        self.assertEqual(numbers[-201:], list(range(back_at - 1, self.count)))
        self.assertEqual(len(numbers), self.count - self.statistics_of(publisher, name).lost)
        wait_until(self.no_more_threads, lambda: "a background thread is left")

    @extended
    def test_last_message_arrives_without_a_following_one(self):
        publisher = self.publisher()
        _, node = self.subscriber(publisher)
        with hanging(node.process.pid):
            size = 20_000_000
            publisher.publish(String(numbered("a", 1, size)))
            publisher.publish(String(numbered("a", 2, SIZE)))
            publisher.publish(String(numbered("a", 3, SIZE)))
        record = self.wait_for(node, self.last(3), "the last message has arrived")
        self.assertEqual((record["numbers"]["a"], record["torn"]), ([1, 3], 0))

    @extended
    def test_subscriber_that_never_reads_and_is_late(self):
        publisher = self.publisher(latch=True)
        _, good = self.subscriber(publisher)
        publisher.publish(String(numbered("a", 0, 10_000_000)))
        self.count = 1
        proxy = xmlrpc.client.ServerProxy(rospy.get_node_uri())
        _, _, (_, host, port) = proxy.requestTopic("/mute", self.topic, [["TCPROS"]])
        with socket.create_connection((host, port)) as mute:
            header = {"topic": self.topic, "md5sum": String._md5sum, "type": String._type}
            mute.sendall(encode_ros_handshake_header({**header, "callerid": "/mute"}))
            wait_until(
                lambda: len(publisher.statistics()) == 2, lambda: "the mute one is not connected"
            )
            wait_until(
                lambda: self.statistics_of(publisher, "/mute").stalled, lambda: "it is not stalled"
            )
            self.publish(publisher, 300)
            self.assertGreaterEqual(self.statistics_of(publisher, "/mute").lost, 299)
            self.assertGreater(self.statistics_of(publisher, "/mute").held_bytes, 10_000_000)
            _, late = self.subscriber(publisher)
            self.wait_for(late, self.last(self.count - 1), "a late joiner has the last message")
        wait_until(lambda: len(publisher.statistics()) == 2, lambda: "the mute one is still there")
        record = self.wait_for(good, self.last(self.count - 1), "all has arrived")
        self.assertEqual(record["numbers"]["a"], list(range(self.count)))
        wait_until(self.no_more_threads, lambda: "a background thread is left")

    @extended
    def test_killed_subscriber_is_dropped(self):
        publisher = self.publisher()
        _, good = self.subscriber(publisher)
        _, killed = self.subscriber(publisher)
        name, stopped = self.subscriber(publisher)
        with hanging(stopped.process.pid):
            self.publish_until_stalled(publisher, name)
            for node in (killed, stopped):
                node.process.kill()
        self.publish(publisher, 20_000, until=lambda: len(publisher.statistics()) == 1)
        record = self.wait_for(good, self.last(self.count - 1), "all has arrived")
        self.assertEqual(record["numbers"]["a"], list(range(self.count)))
        wait_until(self.no_more_threads, lambda: "a background thread is left")

    def test_rosnode_sees_the_connections_and_counts(self):
        publisher = self.publisher()
        name, node = self.subscriber(publisher)
        self.publish(publisher, 10)
        self.wait_for(node, self.last(9), "all has arrived")
        proxy = xmlrpc.client.ServerProxy(rospy.get_node_uri())
        _, _, (published, _, _) = proxy.getBusStats("/test")
        (_, total, connections) = next(entry for entry in published if entry[0] == self.topic)
        self.assertEqual(total, 10 * (8 + SIZE))
        self.assertEqual([(number, up) for _, _, number, up in connections], [(10, True)])
        master = rosgraph.Master(rospy.get_name())
        info = rosnode.get_node_connection_info_description(rospy.get_node_uri(), master)
        self.assertIn(self.topic, info)
        self.assertIn(name, info)

    @extended
    def test_threads_share_a_publisher(self):
        publisher = self.publisher()
        _, node = self.subscriber(publisher)

        def publish(source):
            for number in range(500):
                publisher.publish(String(numbered(source, number, SIZE)))

        threads = [threading.Thread(target=publish, args=(source,)) for source in "ab"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(TIME_OUT)

        def is_all_accounted_for() -> bool:
            (statistics,) = publisher.statistics()
            return bool(statistics.sent + statistics.lost == 1000)

        wait_until(is_all_accounted_for, lambda: str(publisher.statistics()))
        (statistics,) = publisher.statistics()
        record = self.wait_for(
            node,
            lambda record: sum(map(len, record["numbers"].values())) == 1000 - statistics.lost,
            "all has arrived",
        )
        self.assertEqual(record["torn"], 0)
        for source in "ab":
            self.assertEqual(record["numbers"][source], sorted(set(record["numbers"][source])))

    def test_closing_ends_the_connections_and_leaves_nothing_with_the_master(self):
        publisher = self.publisher()
        self.subscriber(publisher)
        publisher.close()
        (published, _, _) = rosgraph.Master(rospy.get_name()).getSystemState()
        self.assertNotIn(self.topic, dict(published))
        proxy = xmlrpc.client.ServerProxy(rospy.get_node_uri())
        _, _, connections = proxy.getBusInfo("/test")
        self.assertNotIn(self.topic, [connection[4] for connection in connections])
        with self.assertRaises(rospy.ROSException):
            publisher.publish(String())

    @extended
    def test_closing_waits_for_a_subscriber_that_takes_what_is_held(self):
        for limit in ("CLOSING_STALL_S", "CLOSING_PATIENCE_S"):  # a busy machine is slow
            module = subscriber_connection if limit == "CLOSING_STALL_S" else delivery
            patience = mock.patch.object(module, limit, TIME_OUT)
            patience.start()
            self.addCleanup(patience.stop)
        publisher = self.publisher(queue_size=20)
        _, node = self.subscriber(publisher)
        for number in range(20):
            publisher.publish(String(numbered("a", number, 5_000_000)))
        publisher.close()
        record = self.wait_for(node, self.last(19), "the last one has arrived")
        self.assertEqual((record["numbers"]["a"], record["torn"]), (list(range(20)), 0))

    @extended
    def test_closing_counts_what_a_stopped_subscriber_loses(self):
        publisher = self.publisher(queue_size=5)
        name, node = self.subscriber(publisher)
        with hanging(node.process.pid), self.assertLogs("rosout", "WARNING") as logged:
            self.publish_until_stalled(publisher, name)
            self.publish(publisher, 10)
            lost = self.statistics_of(publisher, name).lost
            publisher.close()
        (warning,) = [line for line in logged.output if ": closing;" in line]
        expected = rf"{self.topic}: closing; subscriber {name} has not taken (\d+) messages"
        (unsent,) = re.findall(expected, warning)
        received = self.count - lost - int(unsent)
        record = self.wait_for(
            node, lambda one: len(one["numbers"].get("a", [])) >= received, "it reads"
        )
        self.assertEqual(record["numbers"]["a"], list(range(received)))
        self.assertGreaterEqual(int(unsent), 5)

    @extended
    def test_closing_during_opening_leaves_nothing(self):
        publisher = Publisher(self.topic, String)
        register = outgoing_topic.send_directly

        def close_and_register(*arguments):
            publisher.close()
            return register(*arguments)

        with mock.patch.object(outgoing_topic, "send_directly", close_and_register):
            publisher.open()
        (published, _, _) = rosgraph.Master(rospy.get_name()).getSystemState()
        self.assertNotIn(self.topic, dict(published))
        with self.assertRaises(rospy.ROSException):
            publisher.publish(String())

    def test_message_latched_before_opening_reaches_a_late_subscriber(self):
        publisher = Publisher(self.topic, String, latch=True)
        self.addCleanup(publisher.close)
        for number in range(3):
            publisher.publish(String(numbered("a", number, SIZE)))
        publisher.open()
        _, node = self.subscriber(publisher)
        record = self.wait_for(node, self.last(2), "it has the last message")
        self.assertEqual((record["numbers"]["a"], record["torn"]), ([2], 0))

    @extended
    def test_publishing_during_shutdown_raises_nothing(self):
        heard = threading.Event()
        subscription = rospy.Subscriber(self.topic, String, lambda _: heard.set())
        self.addCleanup(subscription.unregister)
        node = Node(self, "endless_publisher.py", self.topic)
        # Not earlier: a signal amid a registration hangs rospy for ever, where run() does not help.
        self.assertTrue(heard.wait(TIME_OUT), "it publishes")
        node.process.send_signal(signal.SIGINT)
        output, errors = node.process.communicate(timeout=TIME_OUT)
        self.assertEqual((node.process.returncode, output), (0, "survived\n"), errors)
        self.assertNotIn("Traceback", errors)


if __name__ == "__main__":
    rospy.init_node("test_publishing")
    rosrun("nodekit", "publishing", PublishingTest)
