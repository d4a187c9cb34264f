"""Helpers of the tests for both ROSes."""

import contextlib
import os
import pathlib
import threading
from typing import Any, Callable, Iterator, List

import rclpy
import rospy
from rcl_interfaces.srv import SetParameters
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile

from nodekit import Subscription
from nodekit.testing.processes import Master, Process
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from ros2_bridge.types.type_registry import TypeRegistry

InvalidHandle = rclpy_implementation.InvalidHandle
SOURCES = pathlib.Path(__file__).resolve().parents[3]
#: The bridge's name, and a setting that is on the server when all are.
NAME = "/ros2_bridge"
TIMEOUT_KEY = f"{NAME}/service_timeout"


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
        self.types = TypeRegistry()
        return self

    def _spin(self) -> None:
        """Spin until the end, even if entities are destroyed while the executor uses them."""
        with contextlib.suppress(ExternalShutdownException):
            while self.node.context.ok():
                with contextlib.suppress(InvalidHandle):
                    self.executor.spin()

    def __exit__(self, *_: Any) -> None:
        end_shared_bridge()
        rospy.signal_shutdown("the tests are over")
        rclpy.shutdown()
        self._thread.join(5.0)
        self.master.kill()

    def call2(self, cls: Any, name: str, **fields: Any) -> Any:
        """Call a service of ROS 2, as ``ros2 service call`` does."""
        client = self.node.create_client(cls, name)
        assert client.wait_for_service(TIMEOUT_S), name
        future = client.call_async(cls.Request(**fields))
        wait_until(future.done, lambda: f"no answer of {name}")
        self.node.destroy_client(client)
        return future.result()

    def offers2(self, name: str) -> bool:
        """Return whether a service exists in ROS 2."""
        return name in dict(self.node.get_service_names_and_types())

    def call1(self, name: str, kind: str, request: bytes, timeout: float = TIMEOUT_S) -> bytes:
        """Call a service of ROS 1."""
        raw = self.types.service(kind).raw
        rospy.wait_for_service(name, timeout)
        message = raw._request_class()
        message._buff = request
        answer: bytes = rospy.ServiceProxy(name, raw)(message)._buff
        return answer

    def hear1(self, topic: str, kind: str) -> "MessageRecorder":
        """Subscribe to a topic in ROS 1.

        Without rospy's subscriber: on a busy machine it connects twice to a publisher that was
        announced twice, and receives everything twice.
        """
        recorder = MessageRecorder()
        raw = self.types.message(kind).raw
        subscription = Subscription(topic, raw, lambda messages, _: recorder.heard.extend(messages))
        subscription.open()
        subscription.receive_latched()
        recorder.end = subscription.close
        return recorder

    def hear2(
        self, topic: str, cls: Any, latched: bool = False, depth: int = 1000
    ) -> "MessageRecorder":
        """Subscribe to a topic in ROS 2."""
        recorder = MessageRecorder()
        kept = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        qos = QoSProfile(depth=depth, durability=kept)
        subscription = self.node.create_subscription(cls, topic, recorder.heard.append, qos)
        recorder.end = lambda: self.node.destroy_subscription(subscription)
        return recorder


class MessageRecorder:
    """Recorder of the messages of a subscription."""

    def __init__(self) -> None:
        self.heard: List[Any] = []
        self.end: Callable[[], Any] = lambda: None

    def wait(self, count: int = 1) -> List[Any]:
        """Wait for a number of messages."""
        wait_until(lambda: len(self.heard) >= count, lambda: f"{len(self.heard)} of {count}")
        return self.heard


class Running(Process):
    """A node of ROS 1, as a process.

    :param package: package of a script
    """

    def __init__(self, package: str, script: str, *arguments: str) -> None:
        super().__init__(str(SOURCES / package / "scripts" / script), arguments)

    def __enter__(self) -> "Running":
        return self

    def __exit__(self, *_: Any) -> None:
        try:
            if self.popen.poll() is None:
                self.interrupt()  # a killed process stays registered, which affects the next test
        finally:
            if self.popen.poll() is None:
                self.end()
            self.print_log()

    def print_log(self) -> None:
        """Print the log, which pytest shows of a test that fails."""
        print("the log:", *self.logged(), sep="\n")


class Bridge(Running):
    """A bridge; the shared one is stopped before, because only one can run at a time."""

    def __init__(self, *arguments: str) -> None:
        end_shared_bridge()
        # What another one was given, by its command line or a launch file, has stayed there.
        with contextlib.suppress(KeyError):
            rospy.delete_param(NAME)
        super().__init__("ros2_bridge", "bridge", *arguments)


#: The bridge that modules share, while it runs.
_shared: List[Bridge] = []


def shared_bridge() -> Bridge:
    """Return the bridge that modules share, with an empty log; start it if it does not run."""
    if not _shared or _shared[0].popen.poll() is not None:
        _shared[:] = [Bridge()]
        wait_until(lambda: rospy.has_param(TIMEOUT_KEY), lambda: "the bridge has no settings yet")
    _shared[0].lines.clear()
    _shared[0].error_lines.clear()
    return _shared[0]


@contextlib.contextmanager
def settings_restored(ros: Both, bridge: Bridge) -> Iterator[None]:
    """Restore a bridge's settings after tests, if it still runs."""
    before = rospy.get_param(NAME)
    yield
    after = rospy.get_param(NAME, {})
    changed = {key: value for key, value in before.items() if after.get(key) != value}
    if changed and bridge.popen.poll() is None:
        request = [Parameter(key, value=value).to_parameter_msg() for key, value in changed.items()]
        ros.call2(SetParameters, f"{NAME}/set_parameters", parameters=request)


def end_shared_bridge() -> None:
    """End the bridge that modules share, if it runs, and forget its settings."""
    while _shared:
        with _shared.pop():
            pass  # which ends it
        rospy.delete_param(NAME)
