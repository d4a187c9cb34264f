"""Faults that users of other bridges report, of a bridge that a test starts in its own way."""

import signal
import threading
from typing import List

import both
import pytest
import rclpy
import rospy
from domains import own_domain
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float32
from test_topics import check_no_echo

from nodekit.testing.waiting import wait_until


def test_bridge_of_another_name_in_a_namespace_has_no_echo(ros: both.Both) -> None:
    with both.Bridge("__name:=link", "__ns:=/lab"):
        check_no_echo(ros)


def test_bridge_ends_at_sigterm_and_leaves_nothing_listed(ros: both.Both) -> None:
    """As docker stop, systemd and kill end a process."""
    node = Node("stays")
    node.create_publisher(Float32, "/stays", 10)
    ros.executor.add_node(node)

    def nodes1() -> List[str]:
        state = rospy.get_master().getSystemState()[2]
        return sorted({name for part in state for _, names in part for name in names})

    with both.Bridge() as bridge:
        wait_until(lambda: "/stays" in nodes1(), lambda: str(nodes1()))
        bridge.popen.send_signal(signal.SIGTERM)
        assert bridge.wait() == 0
        assert not {"/ros2_bridge", "/stays"}.intersection(nodes1())
    ros.executor.remove_node(node)
    node.destroy_node()


def test_two_domains_are_joined_by_a_bridge_each(
    ros: both.Both, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    domain = own_domain()
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    far = Node("far", context=context)
    heard: List[float] = []
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(far)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    far.create_subscription(Float32, "/joined", lambda message: heard.append(message.data), 100)
    out_far = far.create_publisher(Float32, "/joined", 100)
    out = ros.node.create_publisher(Float32, "/joined", 100)
    near = ros.hear2("/joined", Float32)

    def numbers() -> List[List[float]]:
        """Return the numbered messages that were heard in either domain."""
        found = (heard, [message.data for message in near.heard])
        return [sorted(number for number in one if number >= 1.0) for one in found]

    with both.Bridge():
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        with both.Running("ros2_bridge", "bridge", "__name:=ros2_bridge_far") as second:
            wait_until(
                lambda: out.publish(Float32(data=0.0)) or 0.0 in heard,
                lambda: f"nothing from here: {second.logged()}",
            )
            wait_until(
                lambda: out_far.publish(Float32(data=0.5)) or 0.5 in [m.data for m in near.heard],
                lambda: f"nothing from there: {second.logged()}",
            )
            for first in (1, 6):  # the second time behind an echo, if there was one
                for number in range(first, first + 5):
                    out.publish(Float32(data=float(number)))
                    out_far.publish(Float32(data=100.0 + number))
                wait_until(
                    lambda: min(map(len, numbers())) >= 2 * (first + 4),  # noqa: B023
                    lambda: str(numbers()),
                )
            expected = [float(start + number) for start in (0, 100) for number in range(1, 11)]
            assert numbers() == [expected, expected]
    near.end()
    executor.shutdown()
    far.destroy_node()
    rclpy.shutdown(context=context)
    ros.node.destroy_publisher(out)
