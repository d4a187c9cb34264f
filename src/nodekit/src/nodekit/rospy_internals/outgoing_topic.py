"""How rospy publishes.

One implementation object serves all publishers of a topic in a process; rospy itself sends through
it the last message to a late joiner of a latched topic. The one here sends without a queue, and
hands messages to subscribers of the same process without a connection.
"""

import contextlib
import functools
import inspect
import io
import socket
import struct
import time
from typing import Any, ContextManager, Dict, List, Optional, Sequence

import genpy
import rospy
import rospy.core
import rospy.msg
import rospy.topics
from rospy.impl.registration import Registration, get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub

from nodekit.rospy_internals.incoming_topic import IncomingTopic, subscriber_mismatch
from nodekit.rospy_internals.registry import check_topic_type
from nodekit.transport.delivery import deliver
from nodekit.transport.subscriber_connection import SubscriberConnection

_PUBLISHER_ATTRIBUTES = (
    "publock closed connections is_latch latch seq message_data_sent c_lock check "
    "_remove_connection"
)
_TRANSPORT_ATTRIBUTES = "socket endpoint_id stat_bytes stat_num_msg close"

_LENGTH = struct.Struct("<I")


@functools.lru_cache(maxsize=None)
def publisher_mismatch() -> str:
    """Compare rospy's publishers with what this module takes for granted.

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
        if not isinstance(get_topic_manager().subs, dict):
            return "subscriptions are kept in another way"
        return subscriber_mismatch()
    except Exception as error:  # whatever an unknown rospy may raise
        return repr(error)


def send_at_once(
    name: str, data_class: type, latch: bool, lifespan: float
) -> Optional["OutgoingTopic"]:
    """Have a topic's messages sent through :mod:`nodekit.transport.delivery`.

    To be called before the topic is advertised.

    :param name: topic, resolved
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :param lifespan: for how long they get it where it is not latched, s
    :returns: what sends them; None where there is a plain ``rospy.Publisher`` already
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
    topic.lifespan = lifespan
    return topic


class RosSubscriberConnection(SubscriberConnection):
    """A subscriber's connection, whose losses are logged.

    :param transport: rospy's object for it
    :param lock: the topic's lock
    :param topic: the topic's name, for reports
    """

    def __init__(self, transport: TCPROSTransport, lock: ContextManager[Any], topic: str) -> None:
        super().__init__(transport.endpoint_id, transport.socket, lock)
        self._transport = transport
        self._header_bytes = transport.stat_bytes
        self._topic = topic
        # Or else TCP holds small messages back, by up to 40 ms, where the subscriber did not ask.
        with contextlib.suppress(OSError):
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def update_rospy_statistics(self) -> None:
        """Note in rospy's object what has been sent."""
        self._transport.stat_bytes = self._header_bytes + self.sent_bytes
        self._transport.stat_num_msg = self.sent

    def close(self) -> None:
        self._transport.close()

    def report(self, stalled: bool, lost: int) -> None:
        if rospy.is_shutdown():
            return
        what = (self._topic, self.name, lost, self.lost)
        if stalled:
            rospy.logwarn("%s: subscriber %s does not keep up: %d messages lost, %d in all", *what)
        else:
            rospy.loginfo("%s: subscriber %s keeps up again: %d more lost, %d in all", *what)


#: The links of all topics that nobody hears over a connection; never changed.
_NO_CONNECTIONS: Dict[Any, RosSubscriberConnection] = {}


#: What rospy has for a published topic; where it is not known, nothing here is used.
_Topic: Any = getattr(rospy.topics, "_PublisherImpl", object)


class OutgoingTopic(_Topic):
    """A published topic without a queue; one of rospy's implementation objects.

    :param name: topic, resolved
    :param data_class: message class
    """

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.resolved_name = name  # rospy has made a copy, remapped once more
        self._lock: ContextManager[Any] = self.publock  # rospy forgets it on closing
        self._subscriptions: Dict[str, Any] = get_topic_manager().subs
        self._known_connections: Optional[List[Any]] = None
        self._links = _NO_CONNECTIONS
        self.buff = None  # which rospy's own publish() needs alone
        #: for how long a later subscriber gets the last message, s
        self.lifespan = 0.0
        self._last: Any = None
        self._last_expires = 0.0
        #: What a later subscriber gets in place of the last message, where it is latched.
        self._latched: Sequence[Any] = ()
        #: What a subscriber in this process is told of the publisher, as by a connection.
        self.local_header = {
            "callerid": rospy.get_name(),
            "topic": name,
            "type": data_class._type,
            "md5sum": data_class._md5sum,
            "message_definition": data_class._full_text,
        }

    def add_connection(self, c: Any) -> bool:
        """Take a subscriber in, and send it the last message if that is latched or still alive."""
        added = bool(super().add_connection(c))
        with self._lock:  # it may have been sent a message already by now, which is as good
            if c not in self._links and time.monotonic() < self._last_expires:
                self.publish(self._last, c)
            for message in self._latched:
                self.publish(message, c)
        return added

    def latch_all(self, messages: Sequence[Any]) -> None:
        """Let later subscribers get these, in place of the last message.

        :param messages: oldest first; none for the last that is published from now on
        """
        with self._lock:
            self._latched, self.latch = tuple(messages), None

    def set_queue_size(self, queue_size: Optional[int]) -> None:
        """Do without a queue, whatever another publisher of the topic asks for."""

    def publish(self, message: Any, connection_override: Any = None) -> None:
        """Send a message.

        :param message: what to send
        :param connection_override: the one connection to send it to, if not all
        :raises rospy.ROSException: if the topic is closed (but not while the node shuts down) or
            the node is not initialised
        """
        if connection_override is None:
            self.publish_all((message,))
            return
        with self._lock:
            self._update_links()
            link = self._links.get(connection_override)
            if link is not None:
                deliver(self._serialize(message), [link])

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send messages, all at once.

        :param messages: what to send, at least one
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
            listener = self._subscriptions.get(self.resolved_name)
            if listener is not None and not self._is_heard_by(listener):
                listener = None
            is_heard = bool(self._links) or listener is not None
            if not is_heard and not rospy.core.is_initialized():
                raise rospy.ROSException("publish() before init_node()")
            if not (is_heard or self.is_latch or self.lifespan):
                return
            try:
                packets = list(map(self._serialize, messages))
            except genpy.SerializationError as error:
                raise rospy.ROSSerializationException(str(error)) from error
            if self.is_latch:  # only now: what does not fit would keep later subscribers out
                self.latch = None if self._latched else messages[-1]
            elif self.lifespan:
                self._last = messages[-1]
                self._last_expires = time.monotonic() + self.lifespan
            if self._links:
                data = b"".join(packets)
                self.message_data_sent += len(data)
                deliver(data, self._links.values(), len(packets))
        if listener is not None:  # without the lock: it may publish on other topics
            bodies = [packet[_LENGTH.size :] for packet in packets]
            listener.receive_directly(bodies, self.local_header)

    def _is_heard_by(self, topic: Any) -> bool:
        """Tell whether the subscribers in this process are spared a connection."""
        return isinstance(topic, IncomingTopic) and topic.hears(self)

    def _serialize(self, message: Any) -> bytes:
        """Return a message as it goes on the wire, its length before it."""
        self.seq += 1
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

        rospy also removes one that has the same descriptor: where this one is closed already, that
        is a new subscriber to whom the system has given it, and who would hear nothing for ever.
        Closed, it needs not be taken out of epoll.
        """
        if c in connections:
            connections.remove(c)
        with contextlib.suppress(Exception):
            c.close()

    def check(self) -> None:
        """Remove connections that have ended; nobody may come meanwhile and take a descriptor."""
        with self.c_lock:
            super().check()

    def get_stats(self) -> Any:
        """Return the statistics of this topic, in the format of ``getBusStats``."""
        for link in self.links():
            link.update_rospy_statistics()
        return super().get_stats()

    def links(self) -> List[RosSubscriberConnection]:
        """Tell who is subscribed now.

        :returns: a link for each subscriber
        """
        with self._lock:
            self._update_links()
            return list(self._links.values())

    def _update_links(self) -> None:
        # rospy replaces the list on every change: while it is the same, nothing has changed.
        self._known_connections = self.connections
        links: Dict[Any, RosSubscriberConnection] = {}
        for connection in self.connections:
            if connection in self._links:
                links[connection] = self._links[connection]
            elif connection.socket is not None:
                links[connection] = RosSubscriberConnection(
                    connection, self._lock, self.resolved_name
                )
        self._links = links or _NO_CONNECTIONS
