"""Replacement of rospy's subscriber implementation, which passes messages on in batches.

One object serves all subscribers of a topic in a process, and each publisher's connection has a
reading thread. The messages of one read are unpacked and passed on together, without
rospy's chain of buffers. Publishers in the same process call the subscriber in their own thread.
"""

import contextlib
import functools
import inspect
import math
import time
import traceback
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Union

import rospy
import rospy.core
import rospy.topics
from rospy.exceptions import TransportInitError
from rospy.impl.registration import Registration, get_topic_manager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.impl.transport import INBOUND

from nodekit.rospy_internals import registration_listener
from nodekit.rospy_internals.intraprocess_link import IntraprocessLink
from nodekit.rospy_internals.large_arrays import SplitMessage, without_views
from nodekit.rospy_internals.registry import check_topic_type
from nodekit.rospy_internals.tcpros_reader import Reader

#: Called with the messages that have arrived together, oldest first, and whether the calling thread
#: may be blocked, as the thread of a connection may.
BatchCallback = Callable[[List[Any], bool], None]

#: Serialized message without its length.
Body = Union[bytes, SplitMessage]

#: A publisher's new connection may be announced this long before its old one ends [s].
SUCCESSOR_S = 10.0
_SUBSCRIBER_ATTRIBUTES = "callbacks add_connection queue_size statistics_logger closed c_lock"
_TRANSPORT_ATTRIBUTES = "socket read_buff protocol done header stat_bytes stat_num_msg is_latched"


@functools.lru_cache(maxsize=None)
def subscriber_mismatch() -> str:
    """Compare rospy's subscribers with the expectations of this module.

    :returns: the first difference; empty without one
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
                return f"{type(part).__name__} lacks {', '.join(missing)}"
        if list(inspect.signature(topic.receive_callback).parameters) != ["msgs", "connection"]:
            return "receive_callback has other parameters"
        topic.close()
        if list(inspect.signature(transport.receive_once).parameters):
            return "receive_once has parameters"
        add = inspect.signature(get_topic_manager()._add)
        if list(add.parameters) != ["ps", "rmap", "reg_type"]:
            return "topics are added in another way"
    except Exception as error:  # an unknown version of rospy may raise anything
        return repr(error)
    return ""


def receive_in_batches(
    name: str,
    data_class: type,
    callback: BatchCallback,
    newest_only: bool = False,
    takes_views: bool = False,
) -> bool:
    """Pass the messages of a topic on in batches; call this before subscribing.

    :param name: topic, resolved
    :param data_class: message class
    :param callback: called from the thread of the connection or of the publisher
    :param newest_only: whether only the newest messages matter to the callback
    :param takes_views: whether arrays of bytes may be views of shared memory
    :returns: whether that is possible; not if there is a plain ``rospy.Subscriber`` already
    :raises rospy.ROSException: if this process subscribes to it with another type
    """
    manager = get_topic_manager()
    with manager.lock:
        topic = manager.get_subscriber_impl(name)
        check_topic_type(topic, data_class)
        if topic is None:
            topic = IncomingTopic(name, data_class)
            topic.add_batch_callback(callback, newest_only, takes_views)
            manager._add(topic, manager.subs, Registration.SUB)
        elif isinstance(topic, IncomingTopic):
            topic.add_batch_callback(callback, newest_only, takes_views)
        else:
            return False
    return True


def stop_receiving(name: str, callback: BatchCallback) -> None:
    """Remove a batch callback; call this before unsubscribing.

    :param name: topic, resolved
    :param callback: the callback
    """
    topic = get_topic_manager().get_subscriber_impl(name)
    if isinstance(topic, IncomingTopic):
        topic.remove_batch_callback(callback)


def publishers_of(topic: Any) -> Set[str]:
    """Return the names of the nodes whose messages a subscribed topic receives.

    :param topic: rospy's object for the subscribed topic; None once it is closed
    """
    connections = list(getattr(topic, "connections", None) or ())
    names = {str((one.header or {}).get("callerid")) for one in connections} - {"None"}
    has_link = isinstance(topic, IncomingTopic) and topic.intraprocess_link() is not None
    return names | {rospy.get_name()} if has_link else names


def cache_statistics_setting() -> None:
    """Read /enable_statistics once in a process; rospy reads it for each topic."""
    logger = getattr(rospy.topics, "SubscriberStatisticsLogger", None)
    if logger is not None:
        logger.is_enabled = functools.lru_cache(maxsize=None)(logger.is_enabled)


#: rospy's class of a subscribed topic; this module is not used with unknown versions.
_Topic: Any = getattr(rospy.topics, "_SubscriberImpl", object)


class IncomingTopic(_Topic):
    """Subscriber implementation of one topic, derived from rospy's, which receives in batches.

    :param name: topic, resolved
    :param data_class: message class
    """

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.resolved_name = name  # rospy has remapped it a second time
        self._batch_callbacks: List[BatchCallback] = []
        self._takes_views: List[BatchCallback] = []
        #: Readers of the connections, by their ids.
        self._readers: Dict[int, Reader] = {}
        #: Whether connections are read until they are empty, since a callback wants the newest.
        self.reads_until_empty = False
        self._takes_any_type = issubclass(data_class, rospy.AnyMsg)
        self._link: Optional[IntraprocessLink] = None
        #: Time of the latest announcement of each connected publisher, which may be a new one [s].
        self._notified_at: Dict[str, float] = {}

    @property
    def takes_views(self) -> bool:
        """Whether a callback takes views of shared memory."""
        return bool(self._takes_views)

    def add_batch_callback(
        self, callback: BatchCallback, newest_only: bool = False, takes_views: bool = False
    ) -> None:
        """Add a batch callback.

        :param callback: as in :func:`receive_in_batches`
        :param newest_only: as in :func:`receive_in_batches`
        :param takes_views: as in :func:`receive_in_batches`
        """
        if takes_views:
            self._takes_views = self._takes_views + [callback]
        self.reads_until_empty = self.reads_until_empty or newest_only
        self._batch_callbacks = self._batch_callbacks + [callback]

    def remove_batch_callback(self, callback: BatchCallback) -> None:
        """Remove a batch callback.

        :param callback: the callback
        """
        callbacks = list(self._batch_callbacks)
        if callback in callbacks:
            callbacks.remove(callback)
        self._batch_callbacks = callbacks
        self._takes_views = [one for one in self._takes_views if one in callbacks]

    def receive_callback(self, msgs: List[Any], connection: Any) -> None:
        """Pass messages to the callbacks.

        :param msgs: the messages
        :param connection: their connection; None for this process
        """
        callbacks, takes_views = self._batch_callbacks, self._takes_views
        viewed = msgs
        if takes_views and (self.callbacks or len(callbacks) > len(takes_views)):
            msgs = list(map(without_views, msgs))
        if self.callbacks or self.statistics_logger:
            super().receive_callback(msgs, connection)
        for callback in callbacks:
            try:
                callback(viewed if callback in takes_views else msgs, connection is not None)
            except Exception:  # as in rospy: the other callbacks still run
                if not rospy.core.is_shutdown():
                    rospy.logerr("bad callback: %s\n%s", callback, traceback.format_exc())
        if takes_views:  # rospy's loop keeps the list, and so the views, until the next message
            viewed.clear()

    def receive_directly(self, bodies: Sequence[Body], header: Dict[str, str]) -> None:
        """Pass on messages that are published in this process.

        :param bodies: serialized messages, without their lengths
        :param header: the connection header of the publisher
        """
        if self._link is None:
            self._link = self._new_link()
        self._link.count(bodies)
        self.receive_callback(self.copies(bodies, header), None)

    @staticmethod
    def _new_link() -> IntraprocessLink:
        return IntraprocessLink(INBOUND, rospy.get_node_uri() or "")

    def intraprocess_link(self) -> Optional[IntraprocessLink]:
        """Return the link to the publisher in this process; None without one."""
        if not self.receives_from(get_topic_manager().get_publisher_impl(self.resolved_name)):
            return None
        if self._link is None:
            self._link = self._new_link()
        return self._link

    def get_num_connections(self) -> int:
        """Return the number of publishing nodes, with this one."""
        return int(super().get_num_connections()) + (self.intraprocess_link() is not None)

    def get_stats_info(self) -> List[Any]:
        """Return the connections of this topic, in the format of ``getBusInfo``."""
        link = self.intraprocess_link()
        own = [] if link is None else [link.bus_info(self.resolved_name)]
        return list(super().get_stats_info()) + own

    def get_stats(self) -> Any:
        """Return the statistics of this topic, in the format of ``getBusStats``."""
        name, rows = super().get_stats()
        readers = dict(self._readers)
        rows = [
            (*row[:3], readers[row[0]].lost if row[0] in readers else row[3], *row[4:])
            for row in rows
        ]
        link = self.intraprocess_link()
        own = [] if link is None else [(link.id, link.stat_bytes, link.stat_num_msg, -1, True)]
        return name, rows + own

    def copies(self, bodies: Sequence[Body], header: Dict[str, str]) -> List[Any]:
        """Return deserialized copies of messages that are published in this process.

        Publisher and subscriber then share no object, and numbers are rounded as on any
        connection.

        :param bodies: serialized messages, without their lengths
        :param header: the connection header of the publisher
        """
        messages = []
        for body in bodies:
            message = self.data_class()
            if isinstance(body, SplitMessage):
                body.fill(message)
            else:
                message.deserialize(body)
            message._connection_header = header
            messages.append(message)
        return messages

    def receives_from(self, publisher: Any) -> bool:
        """Return whether a publisher's messages arrive through :meth:`receive_directly`.

        :param publisher: rospy's object for the topic's publishers in this process
        """
        return (
            hasattr(publisher, "publish_all")
            and (publisher.data_class is self.data_class or self._takes_any_type)
            and not self.statistics_logger  # rospy's statistics need a connection
        )

    def has_connection(self, endpoint_id: str) -> bool:
        """Return whether a publisher is connected, or needs no connection.

        :param endpoint_id: URI of the publishing node
        """
        if self.is_received_directly(endpoint_id):
            return True
        found = bool(super().has_connection(endpoint_id))
        if found:
            self._notified_at[endpoint_id] = time.monotonic()
        return found

    def remove_connection(self, c: Any) -> None:
        """Remove a publisher's connection that has ended.

        A publisher that is closed and created again may be announced before its old connection
        ends, and would not be announced a second time.

        :param c: rospy's object for it
        """
        super().remove_connection(c)
        reader = self._readers.pop(c.id, None)
        if reader is not None:
            reader.close()
        notified = self._notified_at.pop(c.endpoint_id, -math.inf)
        if time.monotonic() - notified < SUCCESSOR_S and not self.closed:
            registration_listener.connect(self.resolved_name, c.endpoint_id)

    def close(self) -> None:
        """Close the topic's connections."""
        super().close()
        close_poller(self)

    def add_connection(self, c: Any) -> bool:
        """Add a publisher's connection.

        :param c: rospy's object for it
        :returns: whether it is added: not if the topic is closed, or connected already
        """
        # A publisher may be announced twice, or be created again meanwhile. rospy would replace the
        # first connection by the second, and lose the messages sent on the first.
        with self.c_lock:
            if self.has_connection(c.endpoint_id):
                return False
            if type(c) is TCPROSTransport:
                _remove_if_rejected(self, c)
                # Only rospy's own reader keeps the queue size of a plain rospy.Subscriber.
                if self.queue_size is None:
                    reader = self._readers[c.id] = Reader(c, self)
                    c.receive_once = reader.receive_once
            return bool(super().add_connection(c))

    def is_received_directly(self, uri: str) -> bool:
        """Return whether a publisher is in this process and needs no connection.

        :param uri: URI of the publishing node
        """
        publisher = get_topic_manager().get_publisher_impl(self.resolved_name)
        return uri == rospy.get_node_uri() and self.receives_from(publisher)


def close_poller(topic: Any) -> None:
    """Close the descriptor with which rospy polls the connections of a closed topic.

    rospy's object is part of a reference cycle, so the descriptor would stay open until garbage
    collection.

    :param topic: rospy's object for the topic
    """
    with contextlib.suppress(AttributeError):  # no descriptor without epoll
        topic.connection_poll.poller.close()


def _remove_if_rejected(topic: Any, connection: Any) -> None:
    """Remove a connection immediately if the publisher rejects it.

    rospy removes it after a second, and considers it valid until then: a publisher that was just
    created again would never be connected.

    :param topic: rospy's object for the subscribed topic
    :param connection: rospy's object for the connection, not yet connected
    """
    connect = connection.connect

    def connect_or_leave(*args: Any, **kwds: Any) -> None:
        try:
            connect(*args, **kwds)
        except TransportInitError as error:
            topic.remove_connection(connection)
            registration_listener.connection_failed(
                topic.resolved_name, connection.endpoint_id, error
            )
            raise

    connection.connect = connect_or_leave
