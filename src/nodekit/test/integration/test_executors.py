#!/usr/bin/env python3
"""Tests of nodes in executors on a real master, with rospy and roscpp nodes."""

import itertools
import subprocess
import threading
import unittest
from typing import Any, Dict, List

import rospy
import yaml
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import FloatParameter, MultiThreadedExecutor, ParameterSet, SingleThreadedExecutor
from nodekit.node.names import Names
from nodekit.node.ros_node import Node
from nodekit.process.run import init_node
from nodekit.testing.processes import Server
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class Settings(ParameterSet):
    gain = FloatParameter(1.0, minimum=0.0, help="a gain")


class MuxSelect:
    """The service type of that name of topic_tools, a text each way; not all of Debian has it."""

    _type = "topic_tools/MuxSelect"
    _md5sum = "053052240ca985e1f2eedbb0dae9b1f7"
    _request_class = _response_class = String


class Executors(unittest.TestCase):
    """Each test has its own namespace in this process."""

    numbers = itertools.count()

    def setUp(self) -> None:
        self.space = f"/executors{next(self.numbers)}"
        self.threads: List[str] = []
        self.begun, self.may_end = threading.Event(), threading.Event()
        self.addCleanup(self.may_end.set)

    def hold(self, message: String) -> None:
        """Keep the thread that makes this call, until the test lets it go."""
        self.begun.set()
        self.may_end.wait()  # the clean-up ends it too

    def node(self, name: str = "one") -> Node:
        """Return a new node, not started, which is closed at the end."""
        node = Node(Names.hosted(self.space, name))
        self.addCleanup(node.close)
        return node

    def note_thread(self, *_: Any) -> None:
        self.threads.append(threading.current_thread().name)

    def report(self, node: Node) -> Dict[str, Dict[str, Any]]:
        """Return the node's report on its callbacks, by type."""
        answer = rospy.ServiceProxy(node.resolve("~executor"), Trigger)()
        return {entry["kind"]: entry for entry in yaml.safe_load(answer.message)}

    def test_all_calls_are_made_by_its_threads(self) -> None:
        node = self.node()
        executor = SingleThreadedExecutor()
        self.addCleanup(executor.shutdown)
        executor.add_node(node)
        kinds: Dict[str, List[str]] = {}

        def note(kind: str) -> None:
            kinds.setdefault(kind, []).append(threading.current_thread().name)

        def answer(request: Any) -> TriggerResponse:
            note("service")
            return TriggerResponse(True, "")

        node.declare_parameters(Settings, on_change=lambda new, old: note("on_change"))
        node.create_subscription("topic", String, lambda message: note("subscription"))
        node.create_batch_subscription("batches", String, lambda messages: note("batches"))
        node.on_parameter("~beside", lambda value: note("follow"))
        node.create_service("ask", Trigger, answer)
        node.create_timer(100.0, lambda elapsed: note("timer"))
        node.start()
        for topic in ("topic", "batches"):
            node.create_publisher(topic, String).publish("news")
        Server().set(node.name + "/gain", 2.0)
        rospy.ServiceProxy(self.space + "/ask", Trigger)()
        wait_until(lambda: len(kinds) == 6, lambda: str(kinds))
        names = {name for threads in kinds.values() for name in threads}
        self.assertEqual(len(names), 1, kinds)
        self.assertTrue(names.pop().startswith("executor-"), kinds)

    @extended
    def test_describe_and_change_answer_while_all_threads_are_busy(self) -> None:
        node = self.node()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        settings = node.declare_parameters(Settings)
        node.create_subscription("topic", String, self.hold, queue_size=3)
        node.start()
        publisher = node.create_publisher("topic", String)
        for number in range(6):
            publisher.publish(str(number))
            self.begun.wait(TIMEOUT_S)
        answer = rospy.ServiceProxy(node.name + "/describe", Trigger)()
        self.assertIn("gain", answer.message)
        subprocess.run(["rosrun", "nodekit", "change", node.name, "gain", "3"], check=True)
        self.assertEqual(settings.values.gain, 3.0)
        command = ["rosrun", "nodekit", "callbacks", node.name]
        told = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout.decode()
        (words,) = [line.split() for line in told.splitlines() if "subscription" in line]
        self.assertEqual(words[:6], [self.space + "/topic", "subscription", "3", "1", "1", "2"])
        command[-1] = self.space + "/missing"
        refused = subprocess.run(command, stderr=subprocess.PIPE)
        self.assertEqual(refused.returncode, 1)
        self.assertIn(f"/missing has no executor; there is {node.name}", refused.stderr.decode())
        entry = self.report(node)["subscription"]
        self.assertEqual(
            {key: entry[key] for key in ("name", "running", "waiting", "dropped", "made")},
            {"name": self.space + "/topic", "running": 1, "waiting": 3, "dropped": 2, "made": 1},
        )

    def test_report_names_the_cause_of_a_late_timer(self) -> None:
        node = self.node()
        executor = SingleThreadedExecutor()
        self.addCleanup(executor.shutdown)
        executor.add_node(node)
        node.create_subscription("topic", String, self.hold)
        node.start()
        node.create_publisher("topic", String).publish("news")
        self.assertTrue(self.begun.wait(TIMEOUT_S))
        node.create_timer(100.0, self.note_thread)
        wait_until(
            lambda: self.report(node)["timer"]["skipped"] > 3, lambda: str(self.report(node))
        )
        timer, slow = self.report(node)["timer"], self.report(node)["subscription"]
        self.assertEqual((timer["waiting"], timer["made"]), (1, 0))
        self.assertEqual((slow["running"], slow["waiting"]), (1, 0))
        self.may_end.set()
        wait_until(lambda: self.report(node)["timer"]["made"] > 1, lambda: str(self.report(node)))
        self.assertGreater(self.report(node)["timer"]["longest_wait"], 0.03)
        self.assertGreater(self.report(node)["subscription"]["longest"], 0.03)

    def test_only_nodes_in_an_executor_publish_its_statistics(self) -> None:
        node, other = self.node(), self.node("other")
        first, second = SingleThreadedExecutor(), MultiThreadedExecutor(2)
        for made in (first, second):
            self.addCleanup(made.shutdown)
        node.create_subscription("topic", String, self.note_thread)
        node.start()
        other.start()
        publisher = rospy.Publisher(self.space + "/topic", String, queue_size=10)
        wait_until(lambda: publisher.get_num_connections() == 1, lambda: "not connected")

        def thread_of_next() -> str:
            count = len(self.threads)
            publisher.publish("news")
            wait_until(lambda: len(self.threads) > count, lambda: "not heard")
            return self.threads[-1].rpartition("-")[0]

        direct = thread_of_next()
        first.add_node(node)
        in_first = thread_of_next()
        second.add_node(node)  # leaves the first
        in_second = thread_of_next()
        self.assertEqual(len({direct, in_first, in_second}), 3, self.threads)
        self.assertNotIn("executor", direct)
        self.assertIn("subscription", self.report(node))
        first.remove_node(node)  # which has been removed already
        self.assertEqual(thread_of_next(), in_second)
        second.remove_node(node)
        self.assertEqual(thread_of_next(), direct)
        for without in (node, other):
            with self.assertRaises(rospy.ServiceException):
                self.report(without)

    def test_closed_node_calls_nothing_and_leaves_its_executor_to_the_others(self) -> None:
        executor = SingleThreadedExecutor()
        self.addCleanup(executor.shutdown)
        nodes = [self.node(name) for name in ("a", "b")]
        heard: Dict[str, List[str]] = {"a": [], "b": []}
        for node, name in zip(nodes, "ab"):
            executor.add_node(node)
            hear = heard[name]
            node.create_subscription(
                "topic", String, lambda message, hear=hear: hear.append(message.data)
            )
            node.start()
        publisher = nodes[1].create_publisher("topic", String)
        publisher.publish("one")
        wait_until(lambda: heard == {"a": ["one"], "b": ["one"]}, lambda: str(heard))
        nodes[0].close()
        publisher.publish("two")
        wait_until(lambda: heard["b"] == ["one", "two"], lambda: str(heard))
        self.assertEqual(heard["a"], ["one"])

    def test_node_that_is_closed_may_still_go_from_one_executor_to_another(self) -> None:
        nodes = [self.node(name) for name in ("a", "b")]
        for node in nodes:
            node.start()
        before = SingleThreadedExecutor()
        before.add_node(nodes[0])
        for node in nodes:
            node.close()
        for executor in (MultiThreadedExecutor(2), SingleThreadedExecutor()):
            for node in nodes:
                executor.add_node(node)
            self.assertTrue(before.shutdown())
            before = executor
        for node in nodes:
            before.remove_node(node)
        self.assertTrue(before.shutdown())

    def test_topics_with_a_node_of_roscpp_between(self) -> None:
        node = self.node()
        executor = MultiThreadedExecutor(2)
        self.addCleanup(executor.shutdown)
        executor.add_node(node)
        heard: List[str] = []
        node.create_subscription("/relayed", String, lambda message: heard.append(message.data))
        publisher = node.create_publisher("/to_relay", String)
        node.start()
        wait_until(lambda: publisher.get_num_connections() > 0, lambda: "no relay")

        def arrives() -> bool:  # the relay itself may still be connecting to its listener
            publisher.publish("through roscpp")
            return "through roscpp" in heard

        wait_until(arrives, lambda: str(heard))

    def test_services_for_clients_of_rospy_and_roscpp(self) -> None:
        node = self.node()
        executor = MultiThreadedExecutor(2)
        self.addCleanup(executor.shutdown)
        executor.add_node(node)
        asked: List[str] = []

        def select(request: String) -> String:
            asked.append(request.data)
            return String("before")

        def fail(request: Any) -> TriggerResponse:
            raise ValueError("on purpose")

        node.create_service("mux_select", MuxSelect, select)
        node.create_service("fails", Trigger, fail)
        node.start()
        command = ["rosrun", "topic_tools", "switch_mux", self.space + "/mux", "chosen"]
        subprocess.run(command, check=True, timeout=TIMEOUT_S, stdout=subprocess.DEVNULL)
        self.assertEqual(asked, ["chosen"])
        for _ in range(2):
            with self.assertRaisesRegex(rospy.ServiceException, "on purpose"):
                rospy.ServiceProxy(self.space + "/fails", Trigger)()


if __name__ == "__main__":
    init_node("test_executors")
    rosrun("nodekit", "executors", "test_executors")
