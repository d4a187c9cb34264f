"""Nodes of one ROS in the other: ``ros2 node info`` and ``rosnode info``."""

import struct
import subprocess
import time
from typing import Any, Dict, Iterator, List, Set

import both
import pytest
import rospy
from rclpy.node import Node
from std_msgs.msg import Float32, String
from std_srvs.srv import Trigger
from test_topics import publisher1

from basic_comms.msg import SignalMsg
from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until


@pytest.fixture(scope="module")
def generator(bridge: both.Bridge) -> Iterator[both.Running]:
    with both.Running("basic_comms", "signal_generator.py") as running:
        yield running
        running.interrupt()


@pytest.fixture
def lidar(ros: both.Both) -> Iterator[Node]:
    """Return a node of ROS 2 with a topic and a service, that subscribes to two more."""
    node = Node("lidar", namespace="/front")
    node.create_publisher(Float32, "range", 10)
    node.create_subscription(SignalMsg, "/signal", lambda message: None, 10)
    node.create_subscription(String, "/nobody_publishes", lambda message: None, 10)

    def reset(_: Any, response: Any) -> Any:
        response.success = True
        return response

    node.create_service(Trigger, "reset", reset)
    ros.executor.add_node(node)
    yield node
    ros.executor.remove_node(node)
    node.destroy_node()


def published(ros: both.Both, name: str) -> Dict[str, List[str]]:
    """Return the topics that ``ros2 node info`` lists as published by a node, with types."""
    try:
        return dict(ros.node.get_publisher_names_and_types_by_node(name, "/"))
    except Exception:  # rclpy's own: there is no such node yet
        return {}


def rosnode_info(name: str) -> List[str]:
    """Return the lines of ``rosnode info --quiet``."""
    command = ["/usr/bin/rosnode", "info", "--quiet", name]
    done = subprocess.run(command, stdout=subprocess.PIPE, timeout=30.0, check=True)
    return [line.strip() for line in done.stdout.decode().splitlines() if line.strip()]


def sections(lines: List[str]) -> Dict[str, Set[str]]:
    """Return the entries of ``rosnode info`` under each of its headings."""
    found: Dict[str, Set[str]] = {}
    heading = ""
    for line in lines:
        if line.startswith("* "):
            found[heading].add(line[2:])
        else:
            heading = line.partition(":")[0]
            found[heading] = set()
    return found


def test_a_node_of_ros1_publishes_in_ros2(ros: both.Both, generator: both.Running) -> None:
    expected = {
        "/parameter_events": ["rcl_interfaces/msg/ParameterEvent"],
        "/rosout": ["rcl_interfaces/msg/Log"],
        "/signal": ["basic_comms/msg/SignalMsg"],
        "/signal_generator/status": ["std_msgs/msg/String"],
    }
    wait_until(
        lambda: published(ros, "signal_generator") == expected,
        lambda: str(published(ros, "signal_generator")),
    )

    def offered() -> Any:
        return dict(ros.node.get_service_names_and_types_by_node("signal_generator", "/"))

    wait_until(
        lambda: offered().get("/signal_generator/reset") == ["std_srvs/srv/Trigger"],
        lambda: str(offered()),
    )
    assert "/signal" not in published(ros, "ros2_bridge")
    recorder = ros.hear2("/signal", SignalMsg)
    recorder.wait(3)
    recorder.end()


def test_each_publisher_of_a_topic_is_named(ros: both.Both, bridge: both.Bridge) -> None:
    talkers = [
        both.Running("basic_comms", "talker.py", f"__name:={name}") for name in ("left", "right")
    ]

    def names() -> List[str]:
        found = ros.node.get_publishers_info_by_topic("/chatter")
        return sorted(one.node_name for one in found)

    with talkers[0], talkers[1]:
        wait_until(lambda: names() == ["left", "right"], lambda: str(names()))
        recorder = ros.hear2("/chatter", String)
        recorder.wait(10)
        recorder.end()
        talkers[0].interrupt()
        wait_until(lambda: names() == ["right"], lambda: str(names()))
        recorder = ros.hear2("/chatter", String)
        recorder.wait(3)
        recorder.end()
        talkers[1].interrupt()


@pytest.mark.parametrize("latch", [False, True])
@pytest.mark.parametrize("alone", [False, True])
def test_no_message_is_lost_or_doubled_when_a_node_joins(
    ros: both.Both, bridge: both.Bridge, latch: bool, alone: bool
) -> None:
    topic = f"/joined_{latch}_{alone}"
    recorder = ros.hear2(topic, String)
    first = Process("/usr/bin/rostopic", ["pub", "-r", "20", topic, "std_msgs/String", "a"])
    try:
        if alone:
            first.end()
        else:
            recorder.wait(10)
        second = publisher1(ros, topic, "std_msgs/String", latch=latch)
        wait_until(second.get_num_connections, lambda: "the bridge does not subscribe")
        for number in range(1000):  # in all the time from the first message to the next poll
            second.send(b"\x03\0\0\0%03d" % number)
            time.sleep(0.001)
        expected = [f"{number:03}" for number in range(1000)]

        def mine() -> List[str]:
            return [message.data for message in recorder.heard if message.data != "a"]

        wait_until(lambda: len(mine()) >= 1000, lambda: str(sorted({*expected} - {*mine()})))
        rospy.sleep(0.3)  # what is too much would have come by now
        assert mine() == expected
        second.unregister()
    finally:
        first.end()
    recorder.end()


def test_a_node_of_ros2_has_its_own_in_ros1(
    ros: both.Both, generator: both.Running, lidar: Node
) -> None:
    # rosnode knows the types of these from 1.17.4 on; before, it requested only published ones.
    unpublished = {
        "/nobody_publishes": "std_msgs/String",
        "/parameter_events": "rcl_interfaces/ParameterEvent",
    }
    expected = {
        "Publications": {"/front/range [std_msgs/Float32]"},
        "Subscriptions": {
            *(f"{topic} [{type_name}]" for topic, type_name in unpublished.items()),
            "/signal [basic_comms/signal_msg]",
        },
        "Services": {"/front/reset"},
    }

    def listed() -> Dict[str, Set[str]]:
        lines = rosnode_info("/front/lidar")
        for topic, type_name in unpublished.items():
            known = f"{topic} [{type_name}]"
            lines = [line.replace(f"{topic} [unknown type]", known) for line in lines]
        found = sections(lines)
        return {heading: found.get(heading, set()) for heading in expected}

    wait_until(lambda: listed() == expected, lambda: str(listed()))
    assert ros.call1("/front/reset", "std_srvs/Trigger", b"")[:1] == b"\1"
    recorder = ros.hear1("/front/range", "std_msgs/Float32")
    out = next(one for one in lidar.publishers if one.topic_name == "/front/range")
    wait_until(out.get_subscription_count, lambda: "the bridge does not listen")
    for number in range(5):
        out.publish(Float32(data=float(number)))
    recorder.wait(5)
    out.publish(Float32(data=5.0))  # behind what is too much, if anything was
    recorder.wait(6)
    heard = [struct.unpack("<f", message._buff)[0] for message in recorder.heard]
    assert heard == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    recorder.end()
