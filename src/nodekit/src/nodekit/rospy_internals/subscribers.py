"""How rospy receives.

One implementation object serves all subscribers of a topic in a process, and each publisher's
connection has a thread that reads from it, through a chain of buffers made for every case. Here a
short way stands in: what one read brings is unpacked at once and handed over together. What is
published in the same process comes without a connection, in the thread that publishes.
"""

import copy
import functools
import inspect
import struct
import traceback
from typing import Any, Callable, List

import genpy
import rospy
import rospy.core
import rospy.topics
from rospy.exceptions import TransportException, TransportInitError, TransportTerminated
from rospy.impl.registration import Registration, get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub

#: Called with the messages that have arrived together, oldest first.
BatchCallback = Callable[[List[Any]], None]

_SUBSCRIBER_ATTRIBUTES = "callbacks add_connection queue_size statistics_logger"
_TRANSPORT_ATTRIBUTES = "socket read_buff protocol done header stat_bytes stat_num_msg is_latched"
_LENGTH = struct.Struct("<I")
_PREFIX = _LENGTH.size


@functools.lru_cache(maxsize=None)
def subscriber_mismatch() -> str:
    """Compare rospy's subscribers with what this module takes for granted.

    :returns: what is different; empty if nothing is
    """
    try:
        topic = rospy.topics._SubscriberImpl("/mismatch", rospy.AnyMsg)
        protocol = TCPROSSub("/mismatch", rospy.AnyMsg)
        transport = TCPROSTransport(protocol, "/mismatch")
        for part, names in (
            (topic, _SUBSCRIBER_ATTRIBUTES),
            (transport, _TRANSPORT_ATTRIBUTES),
            (protocol, "recv_data_class buff_size"),
        ):
            missing = [name for name in names.split() if not hasattr(part, name)]
            if missing:
                return f"{type(part).__name__} has no {', '.join(missing)}"
        if list(inspect.signature(topic.receive_callback).parameters) != ["msgs", "connection"]:
            return "receive_callback has other parameters"
        topic.close()
        if list(inspect.signature(transport.receive_once).parameters):
            return "receive_once has parameters"
        if list(inspect.signature(get_topic_manager()._add).parameters) != [
            "ps",
            "rmap",
            "reg_type",
        ]:
            return "topics are added in another way"
    except Exception as error:  # whatever an unknown rospy may raise
        return repr(error)
    return ""


def receive_in_batches(name: str, data_class: type, callback: BatchCallback) -> bool:
    """Have the messages of a topic handed over as they arrive, to be called before subscribing.

    :param name: topic
    :param data_class: message class
    :param callback: what to call, from the thread of the connection
    :returns: whether that is possible; not where there is a plain ``rospy.Subscriber`` already
    """
    manager = get_topic_manager()
    resolved_name = rospy.resolve_name(name)
    with manager.lock:
        topic = manager.get_subscriber_impl(resolved_name)
        if topic is None:
            topic = IncomingTopic(resolved_name, data_class)
            topic.add_batch_callback(callback)
            manager._add(topic, manager.subs, Registration.SUB)
        elif isinstance(topic, IncomingTopic):
            topic.add_batch_callback(callback)
        else:
            return False
    publisher = manager.get_publisher_impl(resolved_name)
    if topic.hears(publisher) and publisher.latch is not None:
        callback([copy.deepcopy(publisher.latch)])
    return True


def ask_for_statistics_once() -> None:
    """Have rospy ask the master once in a process, not with each topic, for /enable_statistics."""
    logger = getattr(rospy.topics, "SubscriberStatisticsLogger", None)
    if logger is not None:
        logger.is_enabled = functools.lru_cache(maxsize=None)(logger.is_enabled)


class IncomingTopic(rospy.topics._SubscriberImpl):
    """A subscribed topic that is read by the short way; one of rospy's implementation objects.

    :param name: topic, resolved
    :param data_class: message class
    """

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self._batch_callbacks: List[BatchCallback] = []
        self._header_here = {
            "callerid": rospy.get_name(),
            "topic": name,
            "type": data_class._type,
            "md5sum": data_class._md5sum,
        }

    def add_batch_callback(self, callback: BatchCallback) -> None:
        """Have one more function called.

        :param callback: as in :func:`receive_in_batches`
        """
        self._batch_callbacks = self._batch_callbacks + [callback]

    def receive_callback(self, msgs: List[Any], connection: Any) -> None:
        """Hand messages over.

        :param msgs: what has arrived
        :param connection: where from
        """
        if self.callbacks or self.statistics_logger:
            super().receive_callback(msgs, connection)
        for callback in self._batch_callbacks:
            try:
                callback(msgs)
            except Exception:  # as rospy does it: one callback's defect ends nothing else
                if not rospy.core.is_shutdown():
                    rospy.logerr("bad callback: %s\n%s", callback, traceback.format_exc())

    def receive_here(self, bodies: List[bytes]) -> None:
        """Hand messages over that are published in this process.

        :param bodies: messages as they go on the wire, without their lengths; so each side has a
            copy of its own, and numbers are rounded as for any other subscriber
        """
        messages = []
        for body in bodies:
            message = self.data_class()
            message.deserialize(body)
            message._connection_header = self._header_here
            messages.append(message)
        self.receive_callback(messages, None)

    def hears(self, publisher: Any) -> bool:
        """Tell whether a publisher's messages come through :meth:`receive_here`.

        :param publisher: implementation object of the topic's publishers in this process
        """
        return (
            hasattr(publisher, "publish_all")
            and publisher.data_class is self.data_class
            and not self.statistics_logger  # which rospy feeds with what it knows of a connection
        )

    def has_connection(self, endpoint_id: str) -> bool:
        """Tell whether there is no need to connect to a publisher.

        :param endpoint_id: URI of the publishing node
        """
        if endpoint_id == rospy.get_node_uri():
            publisher = get_topic_manager().get_publisher_impl(self.resolved_name)
            if self.hears(publisher):
                return True
        return bool(super().has_connection(endpoint_id))

    def add_connection(self, c: Any) -> bool:
        """Add a publisher's connection.

        :param c: rospy's object for it
        :returns: whether the topic is open yet
        """
        # A limit of the queue, which a plain rospy.Subscriber may have set, is kept by rospy alone.
        if type(c) is TCPROSTransport and self.queue_size is None:
            c.receive_once = _Reader(c).receive_once
        return bool(super().add_connection(c))


class _Reader:
    """Reads whole messages from one connection.

    :param transport: rospy's object for it
    """

    def __init__(self, transport: TCPROSTransport) -> None:
        self._transport = transport
        self._data_class = transport.protocol.recv_data_class
        self._size = transport.protocol.buff_size
        self._socket: Any = None
        # The beginning of a message that has not arrived as a whole, and its whole length.
        self._parts: List[bytes] = []
        self._have = self._need = 0

    def receive_once(self) -> List[Any]:
        """Wait for messages. Stands in for rospy's method of this name.

        :returns: all that have arrived, oldest first; none if the connection is to end
        :raises TransportTerminated: if the publisher is gone
        :raises TransportException: if there is no connection, or it brings nonsense
        """
        transport = self._transport
        data = self._begin() if transport.socket is not self._socket else b""
        messages = self._unpack(data or self._read())
        while not messages and not transport.done and not rospy.core.is_shutdown():
            messages = self._unpack(self._read())
        transport.stat_num_msg += len(messages)
        if transport.is_latched and messages:
            transport.latch = messages[-1]
        return messages

    def _begin(self) -> bytes:
        """Begin with a new connection; return what came together with its header."""
        sock = self._transport.socket
        if sock is None:
            raise TransportInitError("connection not initialized")
        sock.setblocking(True)
        buffer = self._transport.read_buff
        data = bytes(buffer.getvalue()[: buffer.tell()])
        buffer.seek(0)
        buffer.truncate()
        self._socket = sock
        self._keep(b"")
        return data

    def _read(self) -> bytes:
        try:
            data: bytes = self._socket.recv(self._size)
        except OSError as error:
            raise TransportTerminated("unable to receive data from sender: %s" % error)
        if not data:
            raise TransportTerminated("the sender has closed the connection")
        self._transport.stat_bytes += len(data)
        return data

    def _unpack(self, data: bytes) -> List[Any]:
        if self._parts:
            self._parts.append(data)
            self._have += len(data)
            if self._have < self._need:
                return []
            data = b"".join(self._parts)
        messages: List[Any] = []
        position, end = 0, len(data)
        header = self._transport.header
        while end - position >= _PREFIX:
            body = position + _PREFIX
            stop = body + _LENGTH.unpack_from(data, position)[0]
            if stop > end:
                break
            message = self._data_class()
            try:
                message.deserialize(data[body:stop])
            except genpy.DeserializationError as error:
                raise TransportException("cannot deserialize: %s" % error)
            message._connection_header = header
            messages.append(message)
            position = stop
        if position < end or self._parts:
            self._keep(data[position:])
        return messages

    def _keep(self, data: bytes) -> None:
        """Keep the beginning of a message until the rest is there."""
        self._parts = [data] if data else []
        self._have = len(data)
        self._need = _PREFIX
        if len(data) >= _PREFIX:
            self._need += _LENGTH.unpack_from(data)[0]
