"""DDS participant (rclpy context) of the bridge: creates its ROS 2 nodes and their endpoints."""

import collections
import contextlib
import ctypes
import threading
import time
import uuid
from functools import partial
from typing import Any, Callable, Counter, Dict, List, Set, Tuple

import rclpy
from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from ros2_bridge.ros2.message_queue import MessageQueue
from ros2_bridge.ros2.rcl_take import MessageTaker
from ros2_bridge.ros2.received_message import ReceivedMessage
from ros2_bridge.ros2.wait_loop import Waitable, WaitLoop
from ros2_bridge.rules.settings import HELD_BYTES, QosProfile

#: Number of the 16 bytes of an endpoint's id that identify its participant.
_GUID_PREFIX_SIZE = 12
#: Most bytes of messages passed on before the next are taken from DDS, so that few wait there:
#: DDS limits their number, not their size.
_BATCH_BYTES = 2**23
#: Queue size for calls of a service, as in rclpy.
_CALLS = 10
#: Pause between the end of all nodes and that of the participant [s]: DDS repeats the message that
#: a node has ended until it is received, but only while the participant exists.
_LINGER_S = 0.2
#: Name of the node that keeps the participant alive until then; ``ros2 node list`` hides it.
_LAST_NODE = "/_ros2_bridge_ends"
#: Clears ROS 2's error state of this thread. rcl tries type supports that generated packages
#: lack, collects the errors, and would log for each endpoint that they were truncated.
_reset_error = ctypes.CDLL("librcutils.so").rcutils_reset_error


def _profile(quality: QosProfile, publishes: bool) -> QoSProfile:
    """Return a quality of service as rclpy's class.

    :param publishes: whether it is for a publisher
    """
    kept, lost = DurabilityPolicy.TRANSIENT_LOCAL, ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(
        depth=quality.depth,
        durability=kept if quality.latched else DurabilityPolicy.VOLATILE,
        reliability=lost if quality.best_effort else ReliabilityPolicy.RELIABLE,
        **{name: _as_rclpy(value) for name, value in quality.offered if publishes},
    )


def _as_rclpy(offered: Any) -> Any:
    """Return an offered QoS policy as rclpy's type."""
    if isinstance(offered, str):
        return LivelinessPolicy[offered.upper()]
    return Duration(seconds=offered)


class Participant:
    """DDS participant of the bridge, with its nodes; thread-safe.

    :param name: global name of the bridge's own node
    """

    def __init__(self, name: str) -> None:
        self.context = Context()
        rclpy.init(args=[], context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self._lock = threading.RLock()
        #: Own nodes and their names: a new node may start before the old one of its name has ended.
        self._nodes: Dict[Node, str] = {}
        #: Number of own publishers and subscriptions of each topic.
        self._published: "Counter[str]" = collections.Counter()
        self._subscribed: "Counter[str]" = collections.Counter()
        self.node = self.create_node(name)
        self._taker = MessageTaker()  # for the thread of this loop
        self.messages = WaitLoop(self.context, "messages from ROS 2")
        self.calls = WaitLoop(self.context, "calls from ROS 2")
        self.guid_prefix = self._find_guid_prefix()

    def _find_guid_prefix(self) -> bytes:
        """Return the common prefix of the ids of all own endpoints.

        It is read from a topic that only this node has: a killed bridge may still be listed under
        the same node name.
        """
        topic = f"_{uuid.uuid4().hex}"
        publisher = self.node.create_publisher(ParameterEvent, topic, 1)
        (own,) = self.node.get_publishers_info_by_topic(publisher.topic_name)
        self.node.destroy_publisher(publisher)
        return bytes(own.endpoint_gid)[:_GUID_PREFIX_SIZE]

    def create_node(self, name: str) -> Node:
        """Create a node without parameters, services and log."""
        namespace, _, base = name.rpartition("/")
        quiet = [Parameter("start_type_description_service", value=False)]
        with self._lock:
            node = Node(
                base,
                context=self.context,
                namespace=namespace or "/",
                use_global_arguments=False,
                enable_rosout=False,
                start_parameter_services=False,
                parameter_overrides=quiet,
            )
            self._nodes[node] = name
        return node

    def destroy_node(self, node: Node) -> None:
        """Destroy a node whose entities were removed before."""

        def destroy() -> None:
            with self._lock:
                node.destroy_node()
                del self._nodes[node]

        self.calls.call_between_waits(destroy)

    def create_publisher(self, node: Node, cls: Any, topic: str, quality: QosProfile) -> Any:
        """Create a publisher, whose ``publish`` takes bytes.

        :param node: publishing node
        """
        with self._lock:
            publisher = node.create_publisher(cls, topic, _profile(quality, True))
            _reset_error()
            self._published[topic] += 1
            return publisher

    def destroy_publisher(self, node: Node, publisher: Any) -> None:
        """Destroy a publisher."""
        with self._lock:
            _uncount(self._published, publisher.topic_name)
            node.destroy_publisher(publisher)

    def create_subscription(
        self,
        cls: Any,
        topic: str,
        quality: QosProfile,
        receive: Callable[[List[ReceivedMessage]], None],
    ) -> Callable[[], None]:
        """Subscribe to a topic.

        :param receive: called with the received messages; the oldest are lost if more than
            ``HELD_BYTES`` wait for it
        :returns: function that ends the subscription
        """
        with self._lock:
            subscription = self.node.create_subscription(
                cls, topic, lambda message: None, _profile(quality, False), raw=True
            )
            _reset_error()
            self._subscribed[topic] += 1
        handle = subscription.handle

        queue = MessageQueue(HELD_BYTES)

        def receive_messages(most: int) -> None:
            for _ in range(most):
                message = self._taker.take(handle)
                if message is None:
                    break
                queue.add(message)
            batch = queue.pop_batch(_BATCH_BYTES)
            if queue:  # before the call, which may raise
                self.messages.call_again(waitable)
            receive(batch)

        def destroy() -> None:
            _uncount(self._subscribed, topic)
            self.node.destroy_subscription(subscription)

        waitable = Waitable("subscription", subscription, receive_messages)
        return self._attach(self.messages, waitable, destroy)

    def create_service(
        self,
        node: Node,
        cls: Any,
        name: str,
        answer: Callable[[Any, Callable[[Any], None]], None],
        depth: int = _CALLS,
    ) -> Callable[[], None]:
        """Offer a service.

        :param node: offering node
        :param depth: queue size for requests
        :param answer: called in the loop's thread with the request and a function that sends the
            response, to be called once, from any thread
        :returns: function that ends the service
        """
        with self._lock:
            service = node.create_service(
                cls, name, lambda request, response: response, qos_profile=QoSProfile(depth=depth)
            )
            _reset_error()

        def receive_requests(most: int) -> None:
            for _ in range(most):
                request, header = service.handle.service_take_request(cls.Request)
                if header is None:
                    break
                answer(request, partial(_send, service, header))

        waitable = Waitable("service", service, receive_requests)
        return self._attach(self.calls, waitable, lambda: node.destroy_service(service))

    def create_client(
        self, cls: Any, name: str, receive: Callable[[int], None], depth: int = _CALLS
    ) -> Tuple[Any, Callable[[], None]]:
        """Create a service client.

        :param depth: queue size for responses
        :param receive: takes up to the given number of responses; called in the loop's thread
        :returns: rclpy's client, and a function that ends it
        """
        with self._lock:
            client = self.node.create_client(cls, name, qos_profile=QoSProfile(depth=depth))
            _reset_error()
        waitable = Waitable("client", client, receive)
        return client, self._attach(self.calls, waitable, lambda: self.node.destroy_client(client))

    def _attach(
        self, loop: WaitLoop, waitable: Waitable, destroy: Callable[[], Any]
    ) -> Callable[[], None]:
        """Add an entity to a loop.

        :param destroy: destroys it; called with the lock, once no loop waits for it
        :returns: function that ends it
        """
        loop.add(waitable)

        def locked() -> None:
            with self._lock:
                destroy()

        return lambda: loop.remove(waitable, locked)

    def close(self) -> None:
        """Close everything, and disconnect from ROS 2.

        A participant ends with its last node, and announces that only once: if the message is lost,
        or overtakes those about the nodes, ROS 2 keeps listing them.
        """
        self.messages.close()
        self.calls.close()
        with self._lock:
            nodes = list(self._nodes)
            last = self.create_node(_LAST_NODE)
            for node in nodes:
                node.destroy_node()
            time.sleep(_LINGER_S)
            last.destroy_node()
            rclpy.shutdown(context=self.context)

    def topics(self) -> Set[str]:
        """Return the topics that the bridge publishes or subscribes to."""
        with self._lock:
            return {*self._published, *self._subscribed}

    def is_alone_with(self, topic: str) -> bool:
        """Return quickly whether all publishers and subscriptions of a topic are the bridge's."""
        return bool(
            self.node.count_publishers(topic) == self._published[topic]
            and self.node.count_subscribers(topic) == self._subscribed[topic]
        )

    def latching(self, topic: str) -> Dict[bytes, bool]:
        """Return by publisher id whether each publisher of a topic is transient-local."""
        publishers = self.node.get_publishers_info_by_topic(topic)
        return {bytes(each.endpoint_gid): keeps(each) for each in publishers}

    def own_names(self) -> Set[str]:
        """Return the names of the bridge's nodes."""
        with self._lock:
            return set(self._nodes.values())

    def is_own(self, gid: bytes) -> bool:
        """Return whether an endpoint id belongs to the bridge."""
        return gid.startswith(self.guid_prefix)


def keeps(publisher: Any) -> bool:
    """Return whether a publisher is transient-local.

    :param publisher: rclpy's description of it
    """
    return bool(publisher.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def _uncount(counter: "Counter[str]", topic: str) -> None:
    counter[topic] -= 1
    if not counter[topic]:
        del counter[topic]


def _send(service: Any, header: Any, response: Any) -> None:
    with contextlib.suppress(_rclpy.InvalidHandle):  # closed since the call
        service.send_response(response, header)
