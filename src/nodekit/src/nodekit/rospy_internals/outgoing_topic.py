"""Replacement of rospy's publisher implementation, which sends in the publishing thread.

One object serves all publishers of a topic in a process; rospy uses it to send the last message of
a latched topic to a new subscriber. Subscribers in the same process get messages directly.
"""

import contextlib
import functools
import inspect
import io
import struct
import time
from typing import Any, ContextManager, Dict, List, Optional, Sequence, Union

import genpy
import rospy
import rospy.core
import rospy.msg
import rospy.topics
from rospy.impl.registration import Registration, get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub
from rospy.impl.transport import OUTBOUND

from nodekit.rospy_internals.incoming_topic import (
    IncomingTopic,
    close_poller,
    subscriber_mismatch,
)
from nodekit.rospy_internals.intraprocess_link import IntraprocessLink
from nodekit.rospy_internals.large_arrays import SplitMessage, split, without_views
from nodekit.rospy_internals.registry import check_topic_type
from nodekit.rospy_internals.ros_subscriber_connection import RosSubscriberConnection
from nodekit.rospy_internals.shutdown import ShutdownPhase, at_end
from nodekit.shared_memory.frame import NO_FIELD
from nodekit.shared_memory.segment_pool import Segment
from nodekit.shared_memory.shared_connection import LEAST_BYTES, TopicMemory
from nodekit.transport.delivery import deliver, finish, send_to_all, serve_later
from nodekit.transport.subscriber_connection import SubscriberConnection

_PUBLISHER_ATTRIBUTES = (
    "publock closed connections is_latch latch seq message_data_sent c_lock check "
    "_remove_connection"
)
_TRANSPORT_ATTRIBUTES = "socket endpoint_id stat_bytes stat_num_msg close"

_LENGTH = struct.Struct("<I")

#: Serialized message with its length prefix.
Packet = Union[bytes, SplitMessage]


def _joined(packet: Packet) -> bytes:
    return packet.joined() if isinstance(packet, SplitMessage) else packet


def _body(packet: Packet) -> Packet:
    return packet.body() if isinstance(packet, SplitMessage) else packet[_LENGTH.size :]


@functools.lru_cache(maxsize=None)
def publisher_mismatch() -> str:
    """Compare rospy's publishers with the expectations of this module.

    :returns: the first difference; empty without one
    """
    try:
        topic = rospy.topics._PublisherImpl("/mismatch", rospy.AnyMsg)
        transport = TCPROSTransport(TCPROSPub("/mismatch", rospy.AnyMsg), "/mismatch")
        for part, names in ((topic, _PUBLISHER_ATTRIBUTES), (transport, _TRANSPORT_ATTRIBUTES)):
            missing = [name for name in names.split() if not hasattr(part, name)]
            if missing:
                return f"{type(part).__name__} lacks {', '.join(missing)}"
        if list(inspect.signature(topic.publish).parameters) != ["message", "connection_override"]:
            return "publish has other parameters"
        topic.close()
        if not isinstance(get_topic_manager().subs, dict):
            return "subscriptions are kept in another way"
        return subscriber_mismatch()
    except Exception as error:  # an unknown version of rospy may raise anything
        return repr(error)


def send_directly(
    name: str, data_class: type, latch: bool, lifespan: float, depth: Optional[int] = None
) -> Optional["OutgoingTopic"]:
    """Send a topic's messages through :mod:`nodekit.transport.delivery`.

    Call this before the topic is advertised.

    :param name: topic, resolved
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :param lifespan: how long later subscribers get the last message of an unlatched topic [s]; of
        several publishers, the longest counts
    :param depth: most messages held for a subscriber that does not read, see
        :class:`.SubscriberConnection`; of several publishers, the largest counts
    :returns: the topic; None if this process has a plain ``rospy.Publisher`` of it
    :raises rospy.ROSException: if this process publishes it with another type
    """
    manager = get_topic_manager()
    with manager.lock:
        topic = manager.get_publisher_impl(name)
        check_topic_type(topic, data_class)
        if topic is None:
            topic = OutgoingTopic(name, data_class)
            manager._add(topic, manager.pubs, Registration.PUB)
    if not isinstance(topic, OutgoingTopic):
        return None
    if latch:
        topic.enable_latch()
    topic.lifespan = max(lifespan, topic.lifespan)
    if depth is not None:
        topic.hold_at_least(depth)
    return topic


#: Shared by all topics without a connection; never changed.
_NO_CONNECTIONS: Dict[Any, RosSubscriberConnection] = {}


#: rospy's class of a published topic; this module is not used with unknown versions.
_Topic: Any = getattr(rospy.topics, "_PublisherImpl", object)


class OutgoingTopic(_Topic):
    """Published topic without rospy's queues; one of rospy's implementation objects.

    :param name: topic, resolved
    :param data_class: message class
    """

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.resolved_name = name  # rospy has remapped it a second time
        self._lock: ContextManager[Any] = self.publock  # rospy drops its reference on closing
        self._subscriptions: Dict[str, Any] = get_topic_manager().subs
        self._known_connections: Optional[List[Any]] = None
        self._links = _NO_CONNECTIONS
        self._intraprocess: Optional[IntraprocessLink] = None
        self._memory = TopicMemory(self._lock)
        self.buff = None  # only rospy's own publish() needs it
        #: Most messages held for a subscriber that does not read; None for the newest only.
        self._depth: Optional[int] = None
        #: How long a later subscriber gets the last message [s].
        self.lifespan = 0.0
        self._last: Any = None
        self._last_expires = 0.0
        #: Messages for a later subscriber of a latched topic, in place of the last one.
        self._latched: Sequence[Any] = ()
        #: Connection header for subscribers in this process.
        self.local_header = {
            "callerid": rospy.get_name(),
            "topic": name,
            "type": data_class._type,
            "md5sum": data_class._md5sum,
            "message_definition": data_class._full_text,
        }

    def add_connection(self, c: Any) -> bool:
        """Add a subscriber; send it the last message if latched or within its lifespan."""
        added = bool(super().add_connection(c))  # which publishes what is latched
        with self._lock:
            self._update_links()
            is_new = c in self._links and not self._links[c].has_messages
            if is_new and time.monotonic() < self._last_expires:
                self.publish(self._last, c)
            for message in self._latched:
                self.publish(message, c)
        return added

    def latch_all(self, messages: Sequence[Any]) -> None:
        """Set the messages for later subscribers, in place of the last message.

        :param messages: oldest first; empty for the last that is published from now on
        """
        with self._lock:
            self._latched, self.latch = tuple(messages), None

    def set_queue_size(self, queue_size: Optional[int]) -> None:
        """Ignore the queue size that rospy sets; see :meth:`hold_at_least`."""

    def hold_at_least(self, depth: int) -> None:
        """Hold this many messages for a subscriber that does not read, unless more are held.

        :param depth: number of messages
        """
        with self._lock:
            self._depth = max(depth, self._depth or 0)
            for link in self._links.values():
                link.depth = self._depth

    def publish(self, message: Any, connection_override: Any = None) -> None:
        """Send a message.

        :param message: the message
        :param connection_override: the only connection to send it to; None for all
        :raises rospy.ROSException: if the topic is closed (but not while the node shuts down) or
            the node is not initialised
        """
        if connection_override is None:
            self.publish_all((message,))
            return
        with self._lock:
            self._update_links()
            link = self._links.get(connection_override)
            # While it connected, it may have been sent what is latched, or a newer message.
            if link is not None and not (message is self.latch and link.has_messages):
                deliver(_joined(self._serialize(message)), [link])

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send messages in one delivery.

        :param messages: the messages, at least one
        :raises rospy.ROSSerializationException: if a field has a value that does not fit
        :raises rospy.ROSException: as in :meth:`publish`
        """
        with self._lock:
            if self.closed:
                if rospy.core.is_shutdown_requested():  # topics close before is_shutdown() is true
                    return
                raise rospy.ROSException("publish() to a closed topic")
            if self.connections is not self._known_connections:
                self._update_links()
            listener = self._listener()
            is_heard = bool(self._links) or listener is not None
            if not is_heard and not rospy.core.is_initialized():
                raise rospy.ROSException("publish() before init_node()")
            if not (is_heard or self.is_latch or self.lifespan):
                return
            try:
                packets = list(map(self._serialize, messages))
            except genpy.SerializationError as error:
                raise rospy.ROSSerializationException(str(error)) from error
            # Kept without views, so that their publisher is not kept waiting.
            if self.is_latch:  # an unserializable message would block later subscribers
                self.latch = None if self._latched else without_views(messages[-1])
            elif self.lifespan:
                self._last = without_views(messages[-1])
                self._last_expires = time.monotonic() + self.lifespan
            if self._links:
                self.message_data_sent += sum(map(len, packets))
                if len(packets) == 1 and len(packets[0]) >= LEAST_BYTES:
                    self._deliver_large(packets[0])
                else:  # several are kept or dropped together
                    data = b"".join(map(_joined, packets))
                    deliver(data, self._links.values(), len(packets))
        if listener is not None:  # without the lock: callbacks may publish on other topics
            bodies = list(map(_body, packets))
            self._link_within().count(bodies)
            listener.receive_directly(bodies, self.local_header)

    def _deliver_large(self, packet: Packet) -> None:
        """Send a message through shared memory to the subscribers that read it from there."""
        others = list(self._links.values())
        sharing = [link for link in others if link.shares()]
        segment = self._share(packet) if sharing else None
        full: List[SubscriberConnection] = []
        if segment is not None:
            others = [link for link in others if link not in sharing]
            full += [link for link in sharing if not link.share(segment)]
        if others:
            full += send_to_all(_joined(packet), others)
        serve_later(full)

    def _share(self, packet: Packet) -> Optional[Segment]:
        """Write a message to shared memory; return None if no memory is left."""
        if not isinstance(packet, SplitMessage):
            content = memoryview(packet)[_LENGTH.size :]
            return self._memory.write([content], len(content), len(content), NO_FIELD)
        body = packet.body()
        start = len(body.head)
        stop = start + len(body.array)
        return self._memory.write([body.head, body.array, body.tail], start, stop, body.field)

    def finish(self) -> None:
        """Wait for subscribers that still take held messages; report unsent messages as lost.

        To be called without locks before the topic closes; not if it has another publisher.
        """
        if self.ref_count <= 1:
            _finish([self])

    def close(self) -> None:
        """Close the topic's connections, and give back its memory."""
        super().close()
        close_poller(self)
        with self._lock:
            self._memory.close()

    def _listener(self) -> Optional[IncomingTopic]:
        """Return the subscribed topic in this process that gets messages directly, if any."""
        topic = self._subscriptions.get(self.resolved_name)
        return topic if isinstance(topic, IncomingTopic) and topic.receives_from(self) else None

    def _link_within(self) -> IntraprocessLink:
        if self._intraprocess is None:
            self._intraprocess = IntraprocessLink(OUTBOUND, rospy.get_name())
        return self._intraprocess

    def get_num_connections(self) -> int:
        """Return the number of subscribing nodes, with this one."""
        return int(super().get_num_connections()) + (self._listener() is not None)

    def get_stats_info(self) -> List[Any]:
        """Return the connections of this topic, in the format of ``getBusInfo``."""
        is_heard = self._listener() is not None
        own = [self._link_within().bus_info(self.resolved_name)] if is_heard else []
        return list(super().get_stats_info()) + own

    def _serialize(self, message: Any) -> Packet:
        """Return a serialized message with its length prefix."""
        self.seq += 1
        return split(message, self._to_bytes) or self._to_bytes(without_views(message))

    def _to_bytes(self, message: Any) -> bytes:
        buffer = io.BytesIO()
        if message._has_header:
            rospy.msg.serialize_message(buffer, self.seq, message)
            return buffer.getvalue()
        message.serialize(buffer)
        body = buffer.getvalue()
        return _LENGTH.pack(len(body)) + body

    def remove_connection(self, c: Any) -> None:
        """Remove a subscriber's connection.

        :param c: rospy's object for it
        """
        try:
            super().remove_connection(c)
        except TypeError:  # rospy's close() replaces its lists by None, without a lock
            if not self.closed:
                raise

    def _remove_connection(self, connections: List[Any], c: Any) -> None:
        """Remove a connection from a list, and close it.

        rospy also removes another connection with the same descriptor: if this one is closed
        already, a new subscriber may have that descriptor, and would never get a message.
        A closed descriptor is not in epoll any longer.
        """
        if c in connections:
            connections.remove(c)
        with contextlib.suppress(Exception):
            c.close()

    def check(self) -> None:
        """Remove closed connections, under the lock: a new one could reuse a descriptor."""
        with self.c_lock:
            super().check()

    def get_stats(self) -> Any:
        """Return the statistics of this topic, in the format of ``getBusStats``."""
        for link in self.links():
            link.update_rospy_statistics()
        name, size, rows = super().get_stats()
        if self._listener() is None:
            return name, size, rows
        own = self._link_within()
        return name, size, [*rows, (own.id, own.stat_bytes, own.stat_num_msg, True)]

    def links(self) -> List[RosSubscriberConnection]:
        """Return the connections to subscribers.

        :returns: one for each subscriber
        """
        with self._lock:
            self._update_links()
            return list(self._links.values())

    def _update_links(self) -> None:
        # rospy replaces the list on every change.
        self._known_connections = self.connections
        links: Dict[Any, RosSubscriberConnection] = {}
        for connection in self.connections:
            if connection in self._links:
                links[connection] = self._links[connection]
            elif connection.socket is not None:
                links[connection] = RosSubscriberConnection(
                    connection, self._lock, self.resolved_name, self._depth, self._memory
                )
        self._links = links or _NO_CONNECTIONS


def _finish(topics: Sequence[OutgoingTopic]) -> None:
    for link in finish([link for topic in topics for link in topic.links()]):
        link.report_unsent()


def finish_all() -> None:
    """Wait for the subscribers of all topics together, before rospy closes the topics."""
    topics = list(get_topic_manager().pubs.values())
    _finish([topic for topic in topics if isinstance(topic, OutgoingTopic)])


at_end(ShutdownPhase.PUBLISHERS, finish_all)
