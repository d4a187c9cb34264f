#!/usr/bin/env python3
"""The nodes of the course, as they are started by hand."""

import math
import os
import signal
import threading
import unittest
from typing import Any, Dict, List

import rosnode
import rosparam
import rospy
import yaml
from sensor_msgs.msg import Image
from std_msgs.msg import Float32, String
from std_srvs.srv import Trigger

from my_robot_package.nodes.add_two_ints_server import INT64_MAX, INT64_MIN
from my_robot_package_interfaces.msg import RobotCommand
from my_robot_package_interfaces.srv import AddTwoInts, AddTwoIntsRequest, AddTwoIntsResponse
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.processes import Process, Server
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
SCRIPTS = os.path.join(PACKAGE, "scripts")
CONFIG = os.path.join(PACKAGE, "config", "robot_config.yaml")
#: The nodes that all tests share, with their parameters.
NODES: Dict[str, List[str]] = {
    "service_client_node": ["_period:=0.1"],
    "advanced_node": ["_timer1_period:=0.1", "_timer2_period:=0.05", "_timer1_sleep:=0.3"],
    "logging_node": [],
    "robust_node": ["_recovery_time:=0.05"],
    "efficient_node": ["_processing_time:=0.3"],
    "my_node": ["input_topic:=words"],
    "parameterized_node": [],
    "command_node": ["_velocity:=0.25"],
}


def start(name: str, *arguments: str) -> Process:
    """Start a node."""
    return Process(os.path.join(SCRIPTS, name), arguments)


def results(process: Process, how: str) -> int:
    """Return the number of answers that a client has logged, from its executor's threads."""
    return len(process.logged("Result: 5", f"({how}, executor-1-"))


def in_force(node: str) -> Dict[str, Any]:
    """Return the values that a node says it uses."""
    rospy.wait_for_service(f"{node}/describe", TIMEOUT_S)
    described = rospy.ServiceProxy(f"{node}/describe", Trigger)().message
    return {entry["name"]: entry["value"] for entry in yaml.safe_load(described)}


class Nodes(unittest.TestCase):
    """All of them, at the same time."""

    nodes: Dict[str, Process] = {}

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_nodes")
        cls.nodes = {name: start(name, *arguments) for name, arguments in NODES.items()}

    @classmethod
    def tearDownClass(cls) -> None:
        for process in cls.nodes.values():
            process.end()

    def assert_ends_well(self, process: Process) -> None:
        """Press Ctrl-C."""
        self.assertEqual(process.interrupt(), 0)
        self.assertEqual(process.logged("Traceback"), [])

    def server(self, *arguments: str) -> Process:
        server = start("add_two_ints_server", *arguments)
        self.addCleanup(server.end)
        return server

    def test_my_node_says_hello_and_hears(self) -> None:
        """Course 002-pkg-1."""
        node, recorder = self.nodes["my_node"], MessageRecorder("/topic_name", String)
        node.wait_for_log("MyRobotNode initialized")
        recorder.wait_for(lambda message: message.data == "Hello from my_robot_node")
        publisher = rospy.Publisher("words", String, queue_size=10, latch=True)
        publisher.publish("good morning")
        node.wait_for_log("[INFO]", "I heard: good morning")
        self.assert_ends_well(node)

    def test_parameterized_node_tells_of_a_new_velocity_only(self) -> None:
        """Course 002-pkg-2, err-5."""
        node, server = self.nodes["parameterized_node"], Server()
        node.wait_for_log("default_robot: up to 1.0 m/s, safety on")
        server.wait_for("/parameterized_node/max_velocity", 1.0)
        server.set("/parameterized_node/robot_name", "marvin")
        node.wait_for_log("robot_name: 'default_robot' -> 'marvin'")
        server.set("/parameterized_node/max_velocity", -1.0)
        server.wait_for("/parameterized_node/max_velocity", 1.0)
        server.set("/parameterized_node/max_velocity", 2.5)
        node.wait_for_log("Max velocity updated to: 2.5")
        self.assertEqual(len(node.logged("Max velocity updated")), 1)
        self.assert_ends_well(node)

    def test_command_node_sends_what_its_parameters_say(self) -> None:
        """Course 002-pkg-3."""
        recorder = MessageRecorder("/robot_command", RobotCommand)
        first = recorder.wait_for(lambda command: True)
        self.assertEqual((first.command_type, first.velocity), ("move_to", 0.25))
        Server().set("/command_node/target_position", [1.0, 2.0, 3])
        target = recorder.wait_for(lambda command: command.target_position.x == 1.0).target_position
        self.assertEqual((target.y, target.z), (2.0, 3.0))
        self.assert_ends_well(self.nodes["command_node"])

    def test_launch_file_hands_over_arguments_and_renames_topics(self) -> None:
        """Course 002-pkg-4."""
        recorder = MessageRecorder("/launched/remapped_output_topic", String)
        arguments = "robot_name:=my_robot max_velocity:=0.5 safety_mode:=No __ns:=launched"
        with launched(f"my_robot_package my_launch_file.launch {arguments}") as launch:
            recorder.wait_for(lambda message: message.data == "Hello from my_robot_node")
            graph, node = launch.graph, "/launched/my_robot_node"
            wanted = {"robot_name": "my_robot", "max_velocity": 0.5, "safety_mode": False}
            graph.wait_for_parameters(node, wanted)
            graph.wait_for_parameters("/launched/another_robot_node", {"param1": "value1"})
            topic = "/launched/remapped_input_topic"
            graph.wait_for_publishers(topic, "/launched/another_robot_node")
            graph.wait_for_subscribers(topic, node)

    def test_configuration_file_sets_every_parameter_lists_too(self) -> None:
        """Course 002-pkg-5, 004-bridge-10."""
        ((config, _),) = rosparam.load_file(CONFIG)
        with launched("my_robot_package robot_config.launch __ns:=configured") as launch:
            launch.wait_until_up()
            node = "/configured/my_robot_node"
            self.assertEqual(in_force(node), config)
            self.assertEqual(config["control_topics"], ["/cmd_vel", "/joint_commands"])
            # A dictionary is a namespace: it sets several at once, and the others stay.
            rosparam.set_param(node, "{max_velocity: 0.5, sensor_topics: [/scan]}")
            config.update(max_velocity=0.5, sensor_topics=["/scan"])
            wait_until(lambda: in_force(node) == config, lambda: str(in_force(node)))

    def test_client_waits_asks_in_both_ways_and_outlives_its_server(self) -> None:
        """Course 002-pkg-7."""
        client = self.nodes["service_client_node"]
        client.wait_for_log("Service not available, waiting again...")
        self.assertEqual(results(client, "synchronous"), 0)
        server = self.server()
        for how in ("synchronous", "asynchronous"):
            wait_until(lambda: results(client, how) > 2, lambda: str(client.lines))
        server.popen.send_signal(signal.SIGKILL)
        server.wait()
        client.wait_for_log("Service call failed: /add_two_ints cannot be called")
        told = results(client, "asynchronous")
        self.server("_delay:=0.01")
        wait_until(lambda: results(client, "asynchronous") > told + 2, lambda: str(client.lines))
        self.assert_ends_well(client)

    @extended
    def test_client_tells_of_both_calls_that_fail(self) -> None:
        service = rospy.Service("/unable", AddTwoInts, lambda request: None)
        arguments = ["add_two_ints:=unable", "__name:=unlucky_client", "_period:=3600"]
        client = start("service_client_node", *arguments)
        said = "Service call failed"
        wait_until(lambda: len(client.logged(said)) == 2, lambda: str(client.lines))
        self.assert_ends_well(client)
        service.shutdown()

    def test_client_that_ends_during_its_calls_tells_of_no_failure(self) -> None:
        called = threading.Semaphore(0)
        is_over = threading.Event()
        self.addCleanup(is_over.set)

        def answer(_request: AddTwoIntsRequest) -> AddTwoIntsResponse:
            called.release()
            is_over.wait(TIMEOUT_S)
            return AddTwoIntsResponse()

        service = rospy.Service("/silent", AddTwoInts, answer)
        self.addCleanup(service.shutdown)
        client = start("service_client_node", "add_two_ints:=silent", "__name:=leaving_client")
        for _ in range(2):  # one that waits, and one that does not
            self.assertTrue(called.acquire(timeout=TIMEOUT_S))
        self.assert_ends_well(client)
        self.assertEqual(client.logged("failed"), [])

    def test_sum_that_does_not_fit_is_refused_with_a_sentence(self) -> None:
        self.server("add_two_ints:=sum", "__name:=adder")
        rospy.wait_for_service("/sum")
        add = rospy.ServiceProxy("/sum", AddTwoInts)
        self.assertEqual(add(INT64_MAX, INT64_MIN).sum, -1)
        for a, b in ((INT64_MAX, 1), (INT64_MIN, -1)):
            with self.assertRaises(rospy.ServiceException) as caught:
                add(a, b)
            self.assertIn(f"{a} + {b} is {a + b}: must be in [", str(caught.exception))
        self.assertEqual(add(2, 3).sum, 5)

    @extended
    def test_advanced_node_hears_while_its_timers_exclude_each_other(self) -> None:
        """Course 002-pkg-6."""
        node = self.nodes["advanced_node"]
        publisher = rospy.Publisher("input_topic", String, queue_size=100)
        wait_until(
            lambda: publisher.get_num_connections() == 1, lambda: "the node has not subscribed"
        )

        def between(word: str) -> List[str]:
            """Return the lines with a word that were logged while timer1 slept."""
            publisher.publish("hello")
            found, sleeps = [], False
            for line in list(node.lines):
                sleeps = "timer1 begins" in line or (sleeps and "timer1 ends" not in line)
                if sleeps and word in line:
                    found.append(line)
            return found

        wait_until(lambda: between("I heard: hello"), lambda: str(node.lines))
        wait_until(lambda: len(node.logged("timer2")) > 3, lambda: str(node.lines))
        self.assertEqual(between("timer2"), [])
        self.assert_ends_well(node)

    def test_logging_node_logs_at_each_level_and_tells_of_itself(self) -> None:
        """Course 002-pkg-8."""
        node = self.nodes["logging_node"]
        rospy.wait_for_service("/logging_node/debug_node_info")
        answer = rospy.ServiceProxy("/logging_node/debug_node_info", Trigger)()
        self.assertIn("Node: logging_node, Namespace: /\nTopics: ", answer.message)
        self.assertIn("/logging_node/debug_node_info", answer.message)
        self.assertIn("/rosout", answer.message)
        for line in answer.message.splitlines():
            node.wait_for_log(line)
        self.assertEqual(node.logged("Debug message"), [])
        for level, text in (
            ("[INFO]", "Info message"),
            ("[WARN]", "Warning message"),
            ("[ERROR]", "Error message"),
            ("[FATAL]", "Fatal message"),
            ("[INFO]", "Robot 42 initialized"),
            ("[ERROR]", "Division error: division by zero"),
        ):
            self.assertEqual(len(node.logged(level, text)), 1, text)
        self.assert_ends_well(node)

    def test_robust_node_recovers_and_shuts_down_gracefully(self) -> None:
        """Course 002-pkg-9."""
        node = self.nodes["robust_node"]
        node.wait_for_log("Components initialized at attempt 2")
        self.assertTrue(node.logged("Component initialization failed: no answer"))
        self.assertTrue(node.logged("Attempting recovery procedure..."))
        wait_until(lambda: "/robust_node" in rosnode.get_node_names(), lambda: "not there")
        self.assertEqual(node.logged("Shutting down"), [])
        rospy.wait_for_service("/robust_node/describe", TIMEOUT_S)
        described = rospy.ServiceProxy("/robust_node/describe", Trigger)().message
        effects = {one["name"]: one["takes_effect"] for one in yaml.safe_load(described)}
        own = ("failures", "attempts", "recovery_time")
        self.assertEqual({effects[name] for name in own}, {"at the next start"})
        self.assert_ends_well(node)
        self.assertEqual(len(node.logged("Shutting down gracefully...")), 1)

    def test_robust_node_refuses_what_never_starts(self) -> None:
        """Course 002-pkg-9."""
        node = start("robust_node", "__name:=bad", "_failures:=9", "_recovery_time:=0.01")
        self.addCleanup(node.end)
        self.assertEqual(node.wait(), 1)
        self.assertEqual(node.logged("Traceback"), [])
        self.assertEqual(len(node.logged("Attempting recovery procedure...")), 2)
        self.assertEqual(len(node.logged("[FATAL]", "failed 3 times, the last time: no answer")), 1)
        self.assertNotIn("/bad", rosnode.get_node_names())

    def test_efficient_node_takes_the_newest_image_only(self) -> None:
        """Course 002-pkg-10."""
        recorder = MessageRecorder("/mean_brightness", Float32)
        publisher = rospy.Publisher("image_topic", Image, queue_size=100)
        wait_until(
            lambda: publisher.get_num_connections() == 1 and recorder.publishers() == 1,
            lambda: "not connected",
        )
        publisher.publish(Image(data=b""))  # of which there is nothing to say
        for level in range(1, 101):
            publisher.publish(Image(data=bytes([level, level, level, level + 4])))
        recorder.wait_for(lambda heard: heard.data == 101.0)
        # A longer queue would deliver the last images one after the other.
        heard = {message.data for message in recorder.messages()}
        self.assertFalse({98.0, 99.0, 100.0, 101.0} <= heard, heard)
        self.assertTrue(all(map(math.isfinite, heard)), heard)
        self.assert_ends_well(self.nodes["efficient_node"])


if __name__ == "__main__":
    rosrun("my_robot_package", "nodes", Nodes)
