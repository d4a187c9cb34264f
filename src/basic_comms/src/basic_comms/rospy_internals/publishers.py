"""How rospy publishes.

One implementation object serves all publishers of a topic in a process. Its method ``publish``
is replaced, so that what rospy sends there by itself (the last message to a late joiner of a
latched topic, those of a plain ``rospy.Publisher``) cannot cut into a partly sent message.
"""

import contextlib
import functools
import inspect
import io
import socket
import struct
import threading
from typing import Any, Collection, ContextManager, Dict, List, Optional, Sequence

import rospy
import rospy.core
import rospy.msg
import rospy.topics
from rospy.impl.registration import Registration
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub

from basic_comms import delivery

_PUBLISHER_ATTRIBUTES = (
    "publock closed connections is_latch latch seq message_data_sent enable_latch set_queue_size"
)
_TRANSPORT_ATTRIBUTES = "socket endpoint_id stat_bytes stat_num_msg close"

_LENGTH = struct.Struct("<I")

_take_over_lock = threading.Lock()


@functools.lru_cache(maxsize=None)
def publisher_mismatch() -> str:
    """Compare rospy's publishers with what this section takes for granted.

    :returns: what is different; empty if nothing is
    """
    try:
        topic = rospy.topics._PublisherImpl("/mismatch", rospy.AnyMsg)
        transport = TCPROSTransport(TCPROSPub("/mismatch", rospy.AnyMsg), "/mismatch")
        for part, names in ((topic, _PUBLISHER_ATTRIBUTES), (transport, _TRANSPORT_ATTRIBUTES)):
            missing = [name for name in names.split() if not hasattr(part, name)]
            if missing:
                return f"{type(part).__name__} has no {', '.join(missing)}"
        if list(inspect.signature(topic.publish).parameters) != ["message", "connection_override"]:
            return "publish has other parameters"
        topic.close()
    except Exception as error:  # whatever an unknown rospy may raise
        return repr(error)
    return ""


def take_over_publisher(
    publisher: rospy.Publisher, name: str, data_class: type, latch: bool
) -> "OutgoingTopic":
    """Register a publisher with rospy, but send its messages through :mod:`basic_comms.delivery`.

    :param publisher: object under construction; this stands in for ``rospy.Publisher.__init__``,
        which insists on a queue
    :param name: topic
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :returns: the topic to publish on
    """
    super(rospy.Publisher, publisher).__init__(name, data_class, Registration.PUB)
    implementation = publisher.impl
    implementation.set_queue_size(None)
    if latch:
        implementation.enable_latch()
    with _take_over_lock:
        owner = getattr(implementation.publish, "__self__", None)
        return owner if isinstance(owner, OutgoingTopic) else OutgoingTopic(implementation)


class OutgoingTopic:
    """A published topic whose messages go through :mod:`basic_comms.delivery`.

    :param implementation: rospy's object for the topic
    """

    def __init__(self, implementation: Any) -> None:
        self._implementation = implementation
        self._lock: ContextManager[Any] = implementation.publock  # rospy forgets it on closing
        self._connections: Optional[List[Any]] = None
        self._links: Dict[Any, delivery.Link] = {}
        with self._lock:
            implementation.publish = self.publish

    def publish(self, message: Any, connection_override: Any = None) -> None:
        """Send a message. Stands in for rospy's method of this name.

        :param message: what to send
        :param connection_override: the one connection to send it to, if not all
        :raises rospy.ROSException: if the topic is closed (but not while the node shuts down) or
            the node is not initialised
        """
        self.publish_all([message], connection_override)

    def publish_all(self, messages: Sequence[Any], connection_override: Any = None) -> None:
        """Send messages, all at once.

        :param messages: what to send, at least one
        :param connection_override: as in :meth:`publish`
        :raises rospy.ROSException: as in :meth:`publish`
        """
        topic = self._implementation
        with self._lock:
            if topic.closed:
                if rospy.core.is_shutdown_requested():  # topics close before is_shutdown() is true
                    return
                raise rospy.ROSException("publish() to a closed topic")
            if topic.is_latch:
                topic.latch = messages[-1]
            if topic.connections is not self._connections:
                self._update_links()
            links: Collection[delivery.Link] = self._links.values()
            if connection_override is not None:
                links = [self._links[key] for key in self._links if key is connection_override]
            if not links:
                if not rospy.core.is_initialized():
                    raise rospy.ROSException("publish() before init_node()")
                return
            data = b"".join([self._serialize(message) for message in messages])
            topic.message_data_sent += len(data)
            delivery.deliver(data, links, len(messages))

    def _serialize(self, message: Any) -> bytes:
        """Return a message as it goes on the wire, its length before it."""
        self._implementation.seq += 1
        buffer = io.BytesIO()
        if message._has_header:
            rospy.msg.serialize_message(buffer, self._implementation.seq, message)
            return buffer.getvalue()
        message.serialize(buffer)
        body = buffer.getvalue()
        return _LENGTH.pack(len(body)) + body

    def links(self) -> List[delivery.Link]:
        """Tell who is subscribed now.

        :returns: a link for each subscriber
        """
        with self._lock:
            self._update_links()
            return list(self._links.values())

    def _update_links(self) -> None:
        # rospy replaces the list on every change: while it is the same, nothing has changed.
        self._connections = self._implementation.connections
        links: Dict[Any, delivery.Link] = {}
        for connection in self._implementation.connections:
            if connection in self._links:
                links[connection] = self._links[connection]
            elif not isinstance(connection, TCPROSTransport):
                links[connection] = _QueuedLink(connection, self._lock)
            elif connection.socket is not None:
                topic = self._implementation.resolved_name
                links[connection] = _SubscriberLink(connection, self._lock, topic)
        self._links = links


class _SubscriberLink(delivery.Link):
    """A subscriber's connection.

    :param transport: rospy's object for it
    :param lock: the topic's lock
    :param topic: the topic's name, for reports
    """

    def __init__(self, transport: TCPROSTransport, lock: ContextManager[Any], topic: str) -> None:
        super().__init__(transport.endpoint_id, transport.socket, lock)
        self._transport = transport
        self._topic = topic
        # Or else TCP holds small messages back, by up to 40 ms, where the subscriber did not ask.
        with contextlib.suppress(OSError):
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def count(self, size: int, messages: int) -> None:
        self.sent += messages
        self._transport.stat_bytes += size
        self._transport.stat_num_msg += messages

    def drop(self) -> None:
        self._transport.close()

    def report(self, stalled: bool, lost: int) -> None:
        if rospy.is_shutdown():
            return
        what = (self._topic, self.name, lost, self.lost)
        if stalled:
            rospy.logwarn("%s: subscriber %s does not keep up: %d messages lost, %d in all", *what)
        else:
            rospy.loginfo("%s: subscriber %s keeps up again: %d more lost, %d in all", *what)


class _QueuedLink(delivery.Link):
    """A connection from before the take-over, for which rospy goes on keeping a queue.

    :param connection: rospy's object for it
    :param lock: the topic's lock
    """

    def __init__(self, connection: Any, lock: ContextManager[Any]) -> None:
        super().__init__(connection.endpoint_id, connection, lock)

    def send(self, data: bytes, messages: int) -> bool:
        try:
            self._socket.write_data(data)
            self.sent += messages
        except Exception:  # rospy too takes any to mean that the connection is lost
            self.drop()
        return True
