#!/usr/bin/env python3
"""Tests of rare faults of shared memory: processes that leave, limits of the system, new sizes."""

import contextlib
import os
import pty
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading

import rosbag
import rospy
from helpers.array_subscriber import numbered
from helpers.shared_rig import (
    HELPERS,
    LARGE,
    TIME_OUT,
    RawSubscriber,
    SharedMemoryCase,
    Subscriber,
    mapped,
    memory_files,
)

from nodekit import init_node
from nodekit.shared_memory.shared_connection import MOST_IN_FLIGHT
from nodekit.testing.processes import Master, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

#: Length of the longest message [bytes].
LONGEST = 64_000_000
#: Number of messages in a bag.
RECORDED = 20


class SharedMemoryFaultsTest(SharedMemoryCase):
    """Publishers and subscribers that end, fork, or are short of something."""

    @contextlib.contextmanager
    def publishing(self, first, environment=None):
        """Run a publisher in a separate process, and kill it."""
        script = os.path.join(HELPERS, "array_publisher.py")
        command = [sys.executable, script, str(first), f"topic:={self.topic}"]
        process = subprocess.Popen(command, env=environment)
        try:
            yield process.pid
        finally:
            process.kill()
            process.wait()

    def test_killed_publisher_leaves_nothing_and_another_takes_its_place(self):
        subscriber = Subscriber(self, "views")
        for first, is_read in ((0, True), (1_000_000, False), (2_000_000, True)):
            stopped = contextlib.ExitStack()  # until after the kill
            with stopped, self.publishing(first) as pid:
                wait_until(
                    lambda first=first: subscriber.tell()["numbers"][-1:] > [first + 20],
                    subscriber.tell,
                    timeout=TIME_OUT,
                )
                self.assertGreater(mapped(subscriber.process.pid), 0)
                if not is_read:
                    stopped.enter_context(hanging(subscriber.process.pid))
                    wait_until(
                        lambda pid=pid: memory_files(pid) >= MOST_IN_FLIGHT,
                        lambda: "nothing waits for the stopped subscriber",
                        timeout=TIME_OUT,
                    )
            wait_until(
                lambda: mapped(subscriber.process.pid) == 0,
                lambda: "memory of the killed one is there",
                timeout=TIME_OUT,
            )
        record = subscriber.tell()
        self.assertEqual(record["torn"], 0)
        self.assertEqual(record["numbers"], sorted(set(record["numbers"])))

    def test_child_of_a_killed_subscriber_holds_memory_only_while_it_lives(self):
        publisher = self.new_publisher(queue_size=1)
        (subscriber,) = self.subscribe(publisher, "views")
        (other,) = self.subscribe(publisher, "nodekit")
        subscriber.tell("keep 1")
        self.publish(publisher, LARGE)
        self.wait_for_all(subscriber, other)
        subscriber.tell("fork 2")
        subscriber.process.kill()
        for _ in range(10):
            self.publish(publisher, LARGE)
            self.wait_for_all(other)

        def is_returned():
            self.publish(publisher, LARGE)
            return not self.is_lent(publisher)

        wait_until(is_returned, lambda: "the child's loans are there", timeout=TIME_OUT)
        self.assertEqual(self.wait_for_all(other)[0]["torn"], 0)

    def test_fifty_subscribers_that_leave_at_each_point_cost_the_others_nothing(self):
        publisher = self.new_publisher(queue_size=10)
        before = len(os.listdir("/proc/self/fd"))
        subscribers = [RawSubscriber(self, number) for number in range(50)]
        wait_until(lambda: len(publisher.statistics()) == 50, publisher.statistics)
        reading = subscribers[::5]
        impolite, unopened, unread, holding = (subscribers[n::5] for n in range(1, 5))
        for number in range(20):
            self.publish(publisher, LARGE)
            array = numbered(number, LARGE)
            self.assertTrue(all(one.read() == array for one in reading))
            if number < 3:
                for one in impolite:
                    self.assertTrue(one.read() == array)
                    one.channel.give_back(number)  # once more, or a missing one
            elif number == 3:
                for one in impolite:
                    one.channel._socket.send(b"?")
                for one in unread + holding:
                    frame = one.announced()
                    one.held = one in holding and one.channel.receive(frame.segment)
            elif number == 10:
                for one in unopened + unread + holding + impolite:
                    one.leave()
        wait_until(lambda: len(publisher.statistics()) == len(reading), publisher.statistics)
        for one in publisher.statistics():
            self.assertEqual((one.sent, one.lost), (20, 0))
        for one in reading:
            one.leave()
        self.publish(publisher, LARGE)
        self.assertFalse(self.is_lent(publisher))
        self.assertEqual(self.segments(publisher, is_idle=True), [])
        wait_until(
            lambda: len(os.listdir("/proc/self/fd")) <= before,
            lambda: f"{before} descriptors before, now {len(os.listdir('/proc/self/fd'))}",
        )

    def test_images_flow_through_a_restart_of_the_master(self):
        master = Master()
        self.addCleanup(master.kill)
        environment = dict(os.environ, ROS_MASTER_URI=master.uri)
        subscriber = Subscriber(self, "views", environment=environment)
        with self.publishing(0, environment):

            def goes_on(subscriber):
                count = len(subscriber.tell()["numbers"])
                wait_until(
                    lambda: len(subscriber.tell()["numbers"]) > count + 20,
                    subscriber.tell,
                    timeout=TIME_OUT,
                )

            goes_on(subscriber)
            master.kill()
            goes_on(subscriber)
            master.start()
            goes_on(subscriber)
            later = Subscriber(self, "nodekit", environment=environment)
            goes_on(later)
            for one in (subscriber, later):
                record = one.tell()
                self.assertEqual(record["numbers"], sorted(set(record["numbers"])))
                self.assertEqual(record["torn"], 0)
                self.assertGreater(mapped(one.process.pid), 0)

    def test_limits_of_file_size_and_address_space_lead_to_tcp(self):
        publisher = self.new_publisher(queue_size=100)
        (subscriber,) = self.subscribe(publisher, "nodekit")
        (limited,) = self.subscribe(publisher, "nodekit")
        self.publish(publisher, LARGE)
        self.wait_for_all(subscriber, limited)
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_FSIZE, before)
        resource.setrlimit(resource.RLIMIT_FSIZE, (30_000_000, before[1]))  # of memory files too
        self.publish(publisher, 40_000_000)
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        for record in self.wait_for_all(subscriber, limited):
            self.assertEqual((record["numbers"], record["torn"]), ([0, 1], 0))
        self.assertEqual(self.segments(publisher), [])
        pid = limited.process.pid
        before = resource.prlimit(pid, resource.RLIMIT_AS)
        with open(f"/proc/{pid}/statm") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        resource.prlimit(pid, resource.RLIMIT_AS, (used + LARGE // 2, before[1]))
        self.publish(publisher, 3 * LARGE)
        wait_until(lambda: "TCPROS" in self.transports(), self.transports, timeout=TIME_OUT)
        resource.prlimit(pid, resource.RLIMIT_AS, before)

        def is_back():
            self.publish(publisher, LARGE)
            return limited.has(self.count - 1)

        wait_until(is_back, limited.tell, timeout=TIME_OUT)
        self.assertEqual(self.transports(), ["SHAREDMEM", "TCPROS"])
        uri = rospy.get_master().lookupNode(limited.name)[2]
        self.assertEqual(self.transports(uri), ["TCPROS"])
        for record in self.wait_for_all(subscriber, limited):
            self.assertEqual(record["torn"], 0)

    def test_publisher_without_descriptors_sends_large_messages_by_tcp(self):
        publisher = self.new_publisher(queue_size=100)
        (subscriber,) = self.subscribe(publisher, "nodekit")
        self.publish(publisher, LARGE)
        self.wait_for_all(subscriber)
        before = resource.getrlimit(resource.RLIMIT_NOFILE)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, before)
        most = max(map(int, os.listdir("/proc/self/fd")))
        fillers = [os.dup(0) for _ in range(10)]
        for filler in fillers:
            self.addCleanup(os.close, filler)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, max(fillers)) + 1, before[1]))
        self.publish(publisher, *[3 * LARGE] * 3)
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
        record = self.wait_for_all(subscriber)[0]
        self.assertEqual((record["numbers"], record["torn"]), (list(range(4)), 0))
        self.publish(publisher, 3 * LARGE)
        self.assertEqual(self.wait_for_all(subscriber)[0]["torn"], 0)

    def test_sizes_that_change_with_each_message_arrive_whole(self):
        publisher = self.new_publisher(queue_size=100)
        subscribers = self.subscribe(publisher, "nodekit", "views")
        draw = random.Random(0)
        for _ in range(15):
            exponent = draw.uniform(1.0, 7.8)
            self.publish(publisher, min(LONGEST, int(10.0**exponent)))
            self.wait_for_all(*subscribers)
        self.publish(publisher, LONGEST, 10, LONGEST)
        for record in self.wait_for_all(*subscribers):
            self.assertEqual((record["numbers"], record["torn"]), (list(range(18)), 0))
        self.assertLessEqual(len(self.segments(publisher)), 3)

    def test_many_messages_and_reconnections_leave_no_descriptor(self):
        publisher = self.new_publisher(queue_size=10)
        counts = []

        def descriptors():
            return len(os.listdir("/proc/self/fd"))

        for _ in range(3):
            (subscriber,) = self.subscribe(publisher, "nodekit")
            self.publish(publisher, *[LARGE] * 20, pause=0.001)
            self.wait_for_all(subscriber)
            subscriber.end()

            def has_gone(name=subscriber.name):
                self.publish(publisher, LARGE)
                return all(one.node != name for one in publisher.statistics())

            wait_until(has_gone, publisher.statistics, timeout=TIME_OUT)
            self.segments(publisher, is_idle=True)
            self.assertEqual(memory_files(), 0)
            counts.append(descriptors())
        # The connection of the last one to this node's API may still have to be closed.
        wait_until(lambda: descriptors() <= counts[1], lambda: f"{descriptors()} after {counts}")

    def test_memory_that_is_not_used_is_given_back_in_both_processes(self):
        publisher = self.new_publisher(queue_size=10)
        (subscriber,) = self.subscribe(publisher, "nodekit")
        self.publish(publisher, *[LARGE] * 3)
        self.wait_for_all(subscriber)
        wait_until(
            lambda: memory_files() == mapped(subscriber.process.pid) == 0,
            lambda: f"{memory_files()} and {mapped(subscriber.process.pid)} are left",
            timeout=TIME_OUT,
        )
        wait_until(
            lambda: not any(one.name == "shared memory" for one in threading.enumerate()),
            lambda: "the thread that gave it back is there",
        )
        self.publish(publisher, LARGE)
        self.assertEqual(self.wait_for_all(subscriber)[0]["torn"], 0)

    def test_stock_tools_get_the_same_messages_by_tcp(self):
        publisher = self.new_publisher(queue_size=100)
        (subscriber,) = self.subscribe(publisher, "views")
        with tempfile.TemporaryDirectory() as folder:
            bag = os.path.join(folder, "arrays.bag")
            terminal, its_side = pty.openpty()  # where each line appears immediately
            self.addCleanup(os.close, terminal)
            os.set_blocking(terminal, False)
            # It ends by itself: one that is interrupted has not yet read all that was sent.
            record = ["rosbag", "record", "--limit", str(RECORDED), "-O", bag, self.topic]
            tools = [
                subprocess.Popen(record, stdout=subprocess.DEVNULL),
                subprocess.Popen(["rostopic", "hz", self.topic], stdout=its_side),
            ]
            os.close(its_side)
            for tool in tools:
                self.addCleanup(tool.wait)
                self.addCleanup(tool.kill)
            wait_until(
                lambda: len(publisher.statistics()) == 3, publisher.statistics, timeout=TIME_OUT
            )
            self.publish(publisher, *[LARGE, 100] * 5)
            self.wait_for_all(subscriber)
            self.assertEqual(self.transports(), ["SHAREDMEM", "TCPROS", "TCPROS"])

            shown = bytearray()

            def is_measured():
                self.publish(publisher, LARGE)
                with contextlib.suppress(BlockingIOError):
                    shown.extend(os.read(terminal, 4096))
                return b"average rate" in shown

            def is_recorded():
                self.publish(publisher, LARGE)
                return os.path.exists(bag)  # renamed when it is complete

            wait_until(is_measured, publisher.statistics, timeout=TIME_OUT)
            wait_until(is_recorded, lambda: str(os.listdir(folder)), timeout=TIME_OUT)
            wait_until(
                lambda: all(one.sent == self.count for one in publisher.statistics()),
                publisher.statistics,
            )
            for tool in tools:
                tool.send_signal(signal.SIGINT)
            with rosbag.Bag(bag) as recorded:
                arrays = [message.data for _, message, _ in recorded.read_messages()]
        sent = [numbered(n, 100 if n < 10 and n % 2 else LARGE) for n in range(RECORDED)]
        self.assertEqual(len(arrays), len(sent))
        self.assertTrue(arrays == sent, "the bag has other arrays")


if __name__ == "__main__":
    init_node("test_shared_memory_faults")
    rosrun("nodekit", "shared_memory_faults", SharedMemoryFaultsTest)
