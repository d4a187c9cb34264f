"""How rospy receives.

One implementation object serves all subscribers of a topic in a process, and each publisher's
connection has a thread that reads from it, through a chain of buffers made for every case. Here a
short way stands in: what one read brings is unpacked at once and handed over together. What is
published in the same process comes without a connection, in the thread that publishes.
"""

import functools
import inspect
import math
import time
import traceback
from typing import Any, Callable, Dict, List

import rospy
import rospy.core
import rospy.topics
from rospy.exceptions import TransportInitError
from rospy.impl.registration import Registration, get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub

from nodekit.rospy_internals import registrar
from nodekit.rospy_internals.registry import check_topic_type
from nodekit.rospy_internals.tcpros_reader import Reader

#: Called with the messages that have arrived together, oldest first, and whether the thread is that
#: of a connection, which may be kept waiting.
BatchCallback = Callable[[List[Any], bool], None]

#: How much earlier than the end of a connection news of its successor may come, s.
SUCCESSOR_S = 10.0
_SUBSCRIBER_ATTRIBUTES = "callbacks add_connection queue_size statistics_logger closed c_lock"
_TRANSPORT_ATTRIBUTES = "socket read_buff protocol done header stat_bytes stat_num_msg is_latched"


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
        add = inspect.signature(get_topic_manager()._add)
        if list(add.parameters) != ["ps", "rmap", "reg_type"]:
            return "topics are added in another way"
    except Exception as error:  # whatever an unknown rospy may raise
        return repr(error)
    return ""


def receive_in_batches(name: str, data_class: type, callback: BatchCallback) -> bool:
    """Have the messages of a topic handed over as they arrive, to be called before subscribing.

    :param name: topic, resolved
    :param data_class: message class
    :param callback: what to call, from the thread of the connection or of the publisher
    :returns: whether that is possible; not where there is a plain ``rospy.Subscriber`` already
    :raises rospy.ROSException: if this process subscribes to it with another type
    """
    manager = get_topic_manager()
    with manager.lock:
        topic = manager.get_subscriber_impl(name)
        check_topic_type(topic, data_class)
        if topic is None:
            topic = IncomingTopic(name, data_class)
            topic.add_batch_callback(callback)
            manager._add(topic, manager.subs, Registration.SUB)
        elif isinstance(topic, IncomingTopic):
            topic.add_batch_callback(callback)
        else:
            return False
    return True


def stop_receiving(name: str, callback: BatchCallback) -> None:
    """Hand over nothing more; to be called before unsubscribing.

    :param name: topic, resolved
    :param callback: what was called
    """
    topic = get_topic_manager().get_subscriber_impl(name)
    if isinstance(topic, IncomingTopic):
        topic.remove_batch_callback(callback)


def cache_statistics_setting() -> None:
    """Have rospy ask the master once in a process, not with each topic, for /enable_statistics."""
    logger = getattr(rospy.topics, "SubscriberStatisticsLogger", None)
    if logger is not None:
        logger.is_enabled = functools.lru_cache(maxsize=None)(logger.is_enabled)


#: What rospy has for a subscribed topic; where it is not known, nothing here is used.
_Topic: Any = getattr(rospy.topics, "_SubscriberImpl", object)


class IncomingTopic(_Topic):
    """A subscribed topic that is read by the short way; one of rospy's implementation objects.

    :param name: topic, resolved
    :param data_class: message class
    """

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.resolved_name = name  # rospy has remapped it once more
        self._batch_callbacks: List[BatchCallback] = []
        self._takes_any_type = issubclass(data_class, rospy.AnyMsg)
        #: When the master told of publishers that are connected, s: perhaps of a new one each.
        self._notified_at: Dict[str, float] = {}

    def add_batch_callback(self, callback: BatchCallback) -> None:
        """Have one more function called.

        :param callback: as in :func:`receive_in_batches`
        """
        self._batch_callbacks = self._batch_callbacks + [callback]

    def remove_batch_callback(self, callback: BatchCallback) -> None:
        """Have a function called no longer.

        :param callback: the function
        """
        callbacks = list(self._batch_callbacks)
        if callback in callbacks:
            callbacks.remove(callback)
        self._batch_callbacks = callbacks

    def receive_callback(self, msgs: List[Any], connection: Any) -> None:
        """Hand messages over.

        :param msgs: what has arrived
        :param connection: where from; None for this process
        """
        if self.callbacks or self.statistics_logger:
            super().receive_callback(msgs, connection)
        for callback in self._batch_callbacks:
            try:
                callback(msgs, connection is not None)
            except Exception:  # as rospy does it: one callback's defect ends nothing else
                if not rospy.core.is_shutdown():
                    rospy.logerr("bad callback: %s\n%s", callback, traceback.format_exc())

    def receive_directly(self, bodies: List[bytes], header: Dict[str, str]) -> None:
        """Hand messages over that are published in this process.

        :param bodies: messages as they go on the wire, without their lengths
        :param header: what a connection would tell of the publisher
        """
        self.receive_callback(self.copies(bodies, header), None)

    def copies(self, bodies: List[bytes], header: Dict[str, str]) -> List[Any]:
        """Return messages of this process as a subscriber gets them.

        :param bodies: messages as they go on the wire, without their lengths; so each side has a
            copy of its own, and numbers are rounded as for any other subscriber
        :param header: what a connection would tell of the publisher
        """
        messages = []
        for body in bodies:
            message = self.data_class()
            message.deserialize(body)
            message._connection_header = header
            messages.append(message)
        return messages

    def hears(self, publisher: Any) -> bool:
        """Tell whether a publisher's messages come through :meth:`receive_directly`.

        :param publisher: implementation object of the topic's publishers in this process
        """
        return (
            hasattr(publisher, "publish_all")
            and (publisher.data_class is self.data_class or self._takes_any_type)
            and not self.statistics_logger  # which rospy feeds with what it knows of a connection
        )

    def has_connection(self, endpoint_id: str) -> bool:
        """Tell whether there is no need to connect to a publisher.

        :param endpoint_id: URI of the publishing node
        """
        if self._is_received_directly(endpoint_id):
            return True
        found = bool(super().has_connection(endpoint_id))
        if found:
            self._notified_at[endpoint_id] = time.monotonic()
        return found

    def remove_connection(self, c: Any) -> None:
        """Forget a publisher's connection that has ended.

        A publisher that is closed and made anew may be told of before its old connection is seen to
        end, and nobody would tell of it again.

        :param c: rospy's object for it
        """
        super().remove_connection(c)
        told = self._notified_at.pop(c.endpoint_id, -math.inf)
        if time.monotonic() - told < SUCCESSOR_S and not self.closed:
            registrar.connect(self.resolved_name, c.endpoint_id)

    def add_connection(self, c: Any) -> bool:
        """Add a publisher's connection.

        :param c: rospy's object for it
        :returns: whether it is wanted: the topic is open, and hears nothing twice
        """
        # The node may have closed its publisher when this was begun, and made another since. Or the
        # master told twice of one: rospy would drop the first connection for the second, and with
        # it what had been sent there, or leave the publisher waiting for a header half-way.
        with self.c_lock:
            if self.has_connection(c.endpoint_id):
                return False
            if type(c) is TCPROSTransport:
                _remove_if_rejected(self, c)
                # A limit of the queue, set by a plain rospy.Subscriber, is kept by rospy alone.
                if self.queue_size is None:
                    c.receive_once = Reader(c).receive_once
            return bool(super().add_connection(c))

    def _is_received_directly(self, uri: str) -> bool:
        publisher = get_topic_manager().get_publisher_impl(self.resolved_name)
        return uri == rospy.get_node_uri() and self.hears(publisher)


def _remove_if_rejected(topic: Any, connection: Any) -> None:
    """Have a topic forget a connection at once that a publisher refuses.

    rospy gives it up after a second only, and takes it for a good one until then: of a publisher
    that was just made anew, nothing would be heard for ever.

    :param topic: rospy's implementation object of the subscribed topic
    :param connection: rospy's object for the connection, not connected yet
    """
    connect = connection.connect

    def connect_or_leave(*args: Any, **kwds: Any) -> None:
        try:
            connect(*args, **kwds)
        except TransportInitError:
            topic.remove_connection(connection)
            raise

    connection.connect = connect_or_leave
