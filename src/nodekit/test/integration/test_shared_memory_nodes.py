#!/usr/bin/env python3
"""Tests of large messages between real nodes of all types, which are stopped and killed."""

import gc
import threading

import rospy
from helpers.array_subscriber import numbered
from helpers.shared_rig import (
    LARGE,
    SMALL,
    TIME_OUT,
    SharedMemoryCase,
    mapped,
    memory_files,
)
from std_msgs.msg import UInt8MultiArray

from nodekit import init_node
from nodekit.messaging.subscription import Subscription
from nodekit.shared_memory.shared_connection import MOST_IN_FLIGHT
from nodekit.testing.processes import hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until


class SharedMemoryTest(SharedMemoryCase):
    """A publisher in this process, its subscribers in others."""

    def test_subscribers_of_all_types_get_the_same_messages_in_order(self):
        publisher = self.new_publisher(queue_size=100)
        modes = ("nodekit", "views", "rospy", "nodekit _transport:=tcp")
        subscribers = self.subscribe(publisher, *modes)
        self.publish(publisher, *[SMALL, LARGE, SMALL, SMALL, LARGE, LARGE] * 10)
        kinds = [["bytes"], ["memoryview"], ["bytes"], ["bytes"]]
        for record, types in zip(self.wait_for_all(*subscribers), kinds):
            self.assertEqual(record["numbers"], list(range(60)))
            self.assertEqual((record["torn"], record["types"]), (0, types))
        self.assertEqual(self.transports(), ["SHAREDMEM", "SHAREDMEM", "TCPROS", "TCPROS"])
        for one in publisher.statistics():
            self.assertEqual((one.sent, one.lost), (60, 0))
            uri = rospy.get_master().lookupNode(one.node)[2]
            self.assertIn(self.transports(uri), (["SHAREDMEM"], ["TCPROS"]))

    def test_bus_statistics_count_messages_in_shared_memory(self):
        publisher = self.new_publisher()
        (subscriber,) = self.subscribe(publisher, "nodekit")
        self.publish(publisher, LARGE)
        self.wait_for_all(subscriber)
        (_, _, rows) = publisher._topic.get_stats()
        self.assertEqual(rows[0][2], 1)
        self.assertGreater(rows[0][1], LARGE)

    def test_stopped_subscriber_loses_only_its_own_messages_and_learns_how_many(self):
        publisher = self.new_publisher(queue_size=2)
        (stopped,) = self.subscribe(publisher, "nodekit")
        (other,) = self.subscribe(publisher, "views")
        self.publish(publisher, LARGE)
        self.wait_for_all(stopped, other)
        with hanging(stopped.process.pid):
            for _ in range(30):
                self.publish(publisher, LARGE)
                self.wait_for_all(other)
            self.assertEqual(self.statistics(publisher, other).lost, 0)
            self.assertLessEqual(len(self.segments(publisher)), 6)
        record = self.wait_for_all(stopped)[0]
        lost = self.statistics(publisher, stopped).lost
        self.assertGreater(lost, 20)
        self.assertEqual((len(record["numbers"]), record["torn"]), (31 - lost, 0))
        self.assertEqual(self.missed(stopped), lost)
        self.assertEqual(record["numbers"], sorted(set(record["numbers"])))

    def test_killed_subscriber_leaves_no_memory(self):
        publisher = self.new_publisher(queue_size=10)
        (killed,) = self.subscribe(publisher, "views")
        (other,) = self.subscribe(publisher, "nodekit")
        killed.tell("keep 3")
        self.publish(publisher, *[LARGE] * 3)
        self.wait_for_all(killed, other)
        with hanging(killed.process.pid):
            self.publish(publisher, *[LARGE] * 10, pause=0.01)
            killed.process.kill()
        killed.process.wait()
        self.publish(publisher, LARGE, LARGE)
        record = self.wait_for_all(other)[0]
        self.assertEqual((record["numbers"], record["torn"]), (list(range(self.count)), 0))
        wait_until(lambda: not self.is_lent(publisher), lambda: "it is lent still")
        self.assertEqual(self.segments(publisher, is_idle=True), [])

    def test_arrays_that_a_subscriber_keeps_do_not_change(self):
        publisher = self.new_publisher(queue_size=1)
        (keeper,) = self.subscribe(publisher, "views")
        (other,) = self.subscribe(publisher, "nodekit")
        keeper.tell(f"keep {MOST_IN_FLIGHT}")
        for _ in range(2 * MOST_IN_FLIGHT):
            self.publish(publisher, LARGE)
            self.wait_for_all(other)
        wait_until(lambda: keeper.tell()["kept"], lambda: "the subscriber keeps nothing")
        self.assertTrue(all(keeper.tell()["kept"]))
        wait_until(lambda: self.statistics(publisher, keeper).lost, lambda: "nothing is missed")
        keeper.tell("keep 0")
        self.publish(publisher, LARGE)
        self.wait_for_all(keeper, other)

    def test_closed_publisher_leaves_nothing_in_either_process(self):
        publisher = self.new_publisher(queue_size=10)
        (subscriber,) = self.subscribe(publisher, "nodekit")
        self.publish(publisher, *[LARGE] * 5)
        self.wait_for_all(subscriber)
        self.assertGreater(memory_files(), 0)
        self.assertGreater(mapped(subscriber.process.pid), 0)
        publisher.close()
        del publisher
        wait_until(lambda: memory_files() == 0, lambda: "the publisher has memory")
        wait_until(
            lambda: mapped(subscriber.process.pid) == 0,
            lambda: "the subscriber has memory",
            timeout=TIME_OUT,
        )
        wait_until(
            lambda: not any(one.name == "shared memory" for one in threading.enumerate()),
            lambda: "the thread that gives memory back is there",
        )

    def test_views_are_published_again_in_the_callback_and_after_it(self):
        received = []
        again = Subscription(
            self.topic + "/again",
            UInt8MultiArray,
            lambda messages, _: received.extend(one.data for one in messages),
        )
        self.addCleanup(again.close)
        again.open()
        plain = rospy.Subscriber(self.topic + "/plain", UInt8MultiArray)
        self.addCleanup(plain.unregister)
        publisher = self.new_publisher(queue_size=10)
        (relay,) = self.subscribe(publisher, "relay")
        wait_until(again.publishers, lambda: "the relay is not connected", timeout=TIME_OUT)
        relay.tell("keep 1")
        self.publish(publisher, LARGE, SMALL, LARGE)
        self.wait_for_all(relay)
        wait_until(lambda: len(received) == 3, lambda: len(received), timeout=TIME_OUT)
        relay.tell("publish")
        wait_until(lambda: len(received) == 4, lambda: len(received), timeout=TIME_OUT)
        sent = [numbered(0, LARGE), numbered(1, SMALL), numbered(2, LARGE), numbered(0, LARGE)]
        self.assertTrue(received == sent)
        self.assertIn("field data", relay.tell("refusal"))

    def test_subscription_in_the_process_gets_the_array_itself(self):
        received = []
        has_come = threading.Event()

        def receive(messages, _may_wait):
            received.extend(messages)
            has_come.set()

        subscription = Subscription(self.topic, UInt8MultiArray, receive)
        self.addCleanup(subscription.close)
        subscription.open()
        publisher = self.new_publisher()
        data = bytes(LARGE)
        sent = UInt8MultiArray(data=data)
        publisher.publish(sent)
        self.assertTrue(has_come.wait(TIME_OUT))
        self.assertIs(received[0].data, data)
        self.assertIsNot(received[0], sent)
        sent.data = bytearray(data)
        publisher.publish(sent)
        sent.data[:4] = b"oops"
        self.assertEqual(received[1].data, data)
        gc.collect()


if __name__ == "__main__":
    init_node("test_shared_memory")
    rosrun("nodekit", "shared_memory", SharedMemoryTest)
