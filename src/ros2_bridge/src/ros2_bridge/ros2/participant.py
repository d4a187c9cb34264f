"""DDS participant of the bridge, with many nodes."""

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

from ros2_bridge.ros2.rcl_take import ReceivedMessage, MessageTaker
from ros2_bridge.ros2.wait_loop import Waitable, WaitLoop
from ros2_bridge.rules.settings import Quality

#: Of the 16 bytes that name an endpoint those that name its participant.
_GUID_PREFIX_SIZE = 12
#: How many calls of a service are kept in a burst, as by rclpy.
_CALLS = 10
#: Pause between the end of all nodes and that of the participant [s]: ROS 2's word that a node has
#: gone is repeated until it has arrived, but only while the participant is there.
_LAST_WORD_S = 0.2
#: Name of the node that keeps the participant until then; ``ros2 node list`` hides it.
_LAST_NODE = "/_ros2_bridge_ends"
#: Has ROS 2 forget what has failed in this thread. It tries kinds of type support that twins do not
#: have, collects the failures, and would log for each endpoint that they were truncated.
_forget_failures = ctypes.CDLL("librcutils.so").rcutils_reset_error


def _profile(quality: Quality, publishes: bool) -> QoSProfile:
    """Return a quality of service as rclpy has it.

    :param publishes: whether it is a publisher's
    """
    kept, lost = DurabilityPolicy.TRANSIENT_LOCAL, ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(
        depth=quality.depth,
        durability=kept if quality.latched else DurabilityPolicy.VOLATILE,
        reliability=lost if quality.best_effort else ReliabilityPolicy.RELIABLE,
        **{name: _as_rclpy(value) for name, value in quality.offered if publishes},
    )


def _as_rclpy(offered: Any) -> Any:
    """Return a part of what a publisher offers as rclpy has it."""
    if isinstance(offered, str):
        return LivelinessPolicy[offered.upper()]
    return Duration(seconds=offered)


class Participant:
    """DDS participant of the bridge, with its nodes; may be used from several threads.

    :param name: global name of the bridge's own node
    """

    def __init__(self, name: str) -> None:
        self.context = Context()
        rclpy.init(args=[], context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self._lock = threading.RLock()
        #: Our nodes and their names: a new one may come before the old one of its name has gone.
        self._nodes: Dict[Node, str] = {}
        #: How many publishers and subscriptions of each topic are ours.
        self._published: "Counter[str]" = collections.Counter()
        self._subscribed: "Counter[str]" = collections.Counter()
        self.node = self.create_node(name)
        self._taker = MessageTaker()  # for the thread of this loop
        self.messages = WaitLoop(self.context, "messages from ROS 2")
        self.calls = WaitLoop(self.context, "calls from ROS 2")
        self.guid_prefix = self._find_guid_prefix()

    def _find_guid_prefix(self) -> bytes:
        """Return what the names of all our endpoints begin with.

        They are read from a topic that no other node has: under our node's name, another bridge
        may still be listed that was killed.
        """
        topic = f"_{uuid.uuid4().hex}"
        publisher = self.node.create_publisher(ParameterEvent, topic, 1)
        (own,) = self.node.get_publishers_info_by_topic(publisher.topic_name)
        self.node.destroy_publisher(publisher)
        return bytes(own.endpoint_gid)[:_GUID_PREFIX_SIZE]

    def create_node(self, name: str) -> Node:
        """Make a node without parameters, services and a log of its own."""
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
        """Destroy a node; what it had was removed before."""

        def destroy() -> None:
            with self._lock:
                node.destroy_node()
                del self._nodes[node]

        self.calls.call_between_waits(destroy)

    def create_publisher(self, node: Node, cls: Any, topic: str, quality: Quality) -> Any:
        """Publish a topic: ``publish`` of what is returned takes bytes.

        :param node: who publishes it
        """
        with self._lock:
            publisher = node.create_publisher(cls, topic, _profile(quality, True))
            _forget_failures()
            self._published[topic] += 1
            return publisher

    def destroy_publisher(self, node: Node, publisher: Any) -> None:
        """Publish a topic no longer."""
        with self._lock:
            _uncount(self._published, publisher.topic_name)
            node.destroy_publisher(publisher)

    def create_subscription(
        self,
        cls: Any,
        topic: str,
        quality: Quality,
        receive: Callable[[List[ReceivedMessage]], None],
    ) -> Callable[[], None]:
        """Subscribe to a topic.

        :param receive: called with what has arrived
        :returns: what ends it
        """
        with self._lock:
            subscription = self.node.create_subscription(
                cls, topic, lambda message: None, _profile(quality, False), raw=True
            )
            _forget_failures()
            self._subscribed[topic] += 1
        handle = subscription.handle

        def receive_messages(most: int) -> None:
            messages: List[ReceivedMessage] = []
            while len(messages) < most:
                message = self._taker.take(handle)
                if message is None:
                    break
                messages.append(message)
            receive(messages)

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

        :param node: whose it is
        :param depth: how many requests are kept in a burst
        :param answer: called in the loop's thread with the request and what sends the response,
            once and from any thread
        :returns: what ends it
        """
        with self._lock:
            service = node.create_service(
                cls, name, lambda request, response: response, qos_profile=QoSProfile(depth=depth)
            )
            _forget_failures()

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
        """Make what calls a service.

        :param depth: how many responses are kept in a burst
        :param receive: takes responses that have arrived, up to so many; called in the loop's
            thread
        :returns: rclpy's client, and what ends it
        """
        with self._lock:
            client = self.node.create_client(cls, name, qos_profile=QoSProfile(depth=depth))
            _forget_failures()
        waitable = Waitable("client", client, receive)
        return client, self._attach(self.calls, waitable, lambda: self.node.destroy_client(client))

    def _attach(
        self, loop: WaitLoop, waitable: Waitable, destroy: Callable[[], Any]
    ) -> Callable[[], None]:
        """Have a loop wait for something.

        :param destroy: destroys it; called with the lock, once no loop waits for it
        :returns: what ends it
        """
        loop.add(waitable)

        def locked() -> None:
            with self._lock:
                destroy()

        return lambda: loop.remove(waitable, locked)

    def close(self) -> None:
        """End everything, and disconnect from ROS 2.

        A participant ends with its last node, and says so once: where that is lost, or overtakes
        what was said of the nodes, ROS 2 goes on to list them.
        """
        self.messages.close()
        self.calls.close()
        with self._lock:
            nodes = list(self._nodes)
            last = self.create_node(_LAST_NODE)
            for node in nodes:
                node.destroy_node()
            time.sleep(_LAST_WORD_S)
            last.destroy_node()
            rclpy.shutdown(context=self.context)

    def topics(self) -> Set[str]:
        """Return the topics that we publish or subscribe to."""
        with self._lock:
            return {*self._published, *self._subscribed}

    def is_alone_with(self, topic: str) -> bool:
        """Tell quickly whether all publishers and subscriptions of a topic are ours."""
        return bool(
            self.node.count_publishers(topic) == self._published[topic]
            and self.node.count_subscribers(topic) == self._subscribed[topic]
        )

    def latching(self, topic: str) -> Dict[bytes, bool]:
        """Tell by the name of each publisher of a topic whether it keeps messages for later."""
        publishers = self.node.get_publishers_info_by_topic(topic)
        return {bytes(each.endpoint_gid): keeps(each) for each in publishers}

    def own_names(self) -> Set[str]:
        """Return the names of our nodes."""
        with self._lock:
            return set(self._nodes.values())

    def is_own(self, gid: bytes) -> bool:
        """Tell whether the endpoint of this name is one of our own."""
        return gid.startswith(self.guid_prefix)


def keeps(publisher: Any) -> bool:
    """Tell whether a publisher keeps messages for those who come later.

    :param publisher: as rclpy describes it
    """
    return bool(publisher.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def _uncount(counter: "Counter[str]", topic: str) -> None:
    counter[topic] -= 1
    if not counter[topic]:
        del counter[topic]


def _send(service: Any, header: Any, response: Any) -> None:
    with contextlib.suppress(_rclpy.InvalidHandle):  # it has been closed since it was called
        service.send_response(response, header)
