"""Helpers of the tests: what is needed of either ROS."""

import contextlib
import os
import pathlib
import sys
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Sequence

import rclpy
import rospy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from nodekit.testing.processes import Master, Process
from nodekit.testing.waiting import wait_until
from ros2_bridge.types import MessageType, Types

SCRIPT = str(pathlib.Path(__file__).parents[2] / "scripts" / "bridge")


class Both:
    """A master, and a node in either ROS."""

    def __enter__(self) -> "Both":
        self.master = Master()
        os.environ["ROS_MASTER_URI"] = self.master.uri
        rospy.init_node("tests", disable_signals=True, disable_rosout=True)
        rclpy.init()
        self.node = Node("ros2_tests")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()
        self.types = Types()
        return self

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self.executor.spin()

    def __exit__(self, *_: Any) -> None:
        rospy.signal_shutdown("the tests are over")
        rclpy.shutdown()
        self._thread.join(5.0)
        self.master.kill()

    def hear1(self, topic: str, kind: str) -> "Ear":
        """Hear a topic in ROS 1."""
        raw = self.types.message(kind).raw
        ear = Ear()
        ear.end = rospy.Subscriber(topic, raw, ear.take, tcp_nodelay=True).unregister
        return ear

    def hear2(self, topic: str, cls: Any, latched: bool = False, depth: int = 1000) -> "Ear":
        """Hear a topic in ROS 2."""
        ear = Ear()
        kept = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        qos = QoSProfile(depth=depth, durability=kept)
        subscription = self.node.create_subscription(cls, topic, ear.take, qos)
        ear.end = lambda: self.node.destroy_subscription(subscription)
        return ear


class Ear:
    """Keeps what a subscription hears."""

    def __init__(self) -> None:
        self.heard: List[Any] = []
        self.end: Callable[[], Any] = lambda: None

    def take(self, message: Any) -> None:
        self.heard.append(message)

    def wait(self, count: int = 1) -> List[Any]:
        """Wait until so many have come."""
        wait_until(lambda: len(self.heard) >= count, lambda: f"{len(self.heard)} of {count}")
        return self.heard


class Bridge(Process):
    """The bridge, as a process."""

    def __init__(self, *arguments: str) -> None:
        super().__init__(SCRIPT, arguments)

    def __enter__(self) -> "Bridge":
        return self

    def __exit__(self, *_: Any) -> None:
        if self.popen.poll() is None:
            self.end()
        print("the bridge's log:", *self.logged(), sep="\n")
