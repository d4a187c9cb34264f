"""Publisher that sends immediately, and that a stalled subscriber cannot block."""

import io
import sys
import threading
import time
from typing import Any, List, Mapping, NamedTuple, Optional, Sequence, Set

import genpy
import rospy
import rospy.core

from nodekit.argument_checks import check_message_class
from nodekit.rospy_internals import outgoing_topic, registry

#: Queue size of the plain publisher that is used with an unknown version of rospy.
FALLBACK_QUEUE_SIZE = 100


class InvalidField(rospy.ROSSerializationException, TypeError):
    """Error of a field whose value does not fit its type; as rospy's own, and a TypeError."""


class SubscriberStatistics(NamedTuple):
    """Counters of the messages to one subscriber."""

    #: name of the subscribing node
    node: str
    #: messages sent
    sent: int
    #: messages dropped because the subscriber did not read
    lost: int
    #: whether the subscriber has taken nothing for 50 ms, and data waits for it
    stalled: bool
    #: bytes held for the subscriber because it has not read them yet
    held_bytes: int


def _depth(queue_size: int, name: str) -> int:
    """Return how many messages are held; raise a ValueError for an invalid queue size."""
    if not isinstance(queue_size, int) or queue_size < -1:
        must = "must be a whole number of at least 1, or 0 or -1 for no limit"
        raise ValueError(f"topic {name}: queue_size: refused {queue_size!r}: {must}")
    return queue_size if queue_size > 0 else sys.maxsize


class Publisher:
    """Publisher of a topic, which sends in the calling thread.

    :meth:`publish` returns when the operating system has the message: latency is lowest, and a
    subscriber that reads loses nothing. For a subscriber that does not read, the newest
    ``queue_size`` messages are held, and sent in the background. Without a queue size, it blocks
    one call, for up to 50 ms; then it gets only the newest message until it reads again. Its lost
    messages are counted and reported; messages are never split. Thread-safe.

    Before the publisher is open, the last message of a latched topic is kept, and sent on opening.

    :param name: topic, resolved
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :param lifespan: how long later subscribers get the last message of an unlatched topic [s]: a
        node that starts a moment later does not have to wait for the next one. Not in the same
        process, where subscriptions open before the first message is published
    :param queue_size: most messages held for a subscriber that does not read, 0 or -1 for no limit
        but :data:`.MOST_HELD` bytes; :meth:`publish` never waits for a subscriber then. Of several
        publishers of the topic in the process, the largest counts
    :raises TypeError: if the class is not a message class
    :raises ValueError: if the queue size is not a whole number of at least -1
    """

    __slots__ = (
        "resolved_name",
        "data_class",
        "_latch",
        "_lifespan",
        "_depth",
        "_first",
        "_lock",
        "_publisher",
        "_topic",
        "_is_closed",
    )

    def __init__(
        self,
        name: str,
        data_class: type,
        latch: bool = False,
        lifespan: float = 0.0,
        queue_size: Optional[int] = None,
    ) -> None:
        check_message_class(data_class, name)
        self.resolved_name = name
        self.data_class = data_class
        self._latch = latch
        self._lifespan = lifespan
        self._depth = None if queue_size is None else _depth(queue_size, name)
        self._first: Any = None
        self._lock = threading.Lock()  # held only to keep the first message, or take it
        self._publisher: Optional[rospy.Publisher] = None
        self._topic: Optional[outgoing_topic.OutgoingTopic] = None
        self._is_closed = False

    def open(self) -> None:
        """Advertise the topic, unless the publisher is closed."""
        if self._is_closed:
            return
        mismatch = outgoing_topic.publisher_mismatch()
        if mismatch:
            rospy.logwarn_once("unsupported rospy version: publishing with queues: %s", mismatch)
        name, data_class = self.resolved_name, self.data_class
        topic: Optional[outgoing_topic.OutgoingTopic] = None
        with registry.topic_lock():
            if not mismatch:
                topic = outgoing_topic.send_directly(
                    name, data_class, self._latch, self._lifespan, self._depth
                )
            publisher = rospy.Publisher(
                registry.name_before_remapping(name),
                data_class,
                latch=self._latch,
                queue_size=self._depth or FALLBACK_QUEUE_SIZE,
            )
        publisher.name = publisher.resolved_name = name  # rospy has made copies of the text
        while True:  # another thread may publish meanwhile; the newest is latched
            with self._lock:
                first, self._first = self._first, None
                if first is None:
                    self._publisher, self._topic = publisher, topic
                    break
            if topic is not None:
                topic.publish_all((first,))
            else:
                publisher.publish(first)
        if self._is_closed:  # by another thread meanwhile
            self.close()

    def close(self) -> None:
        """Stop publishing, after up to 2 s for subscribers that still take held messages.

        At the end of the process, :func:`.finish_all` waits for those of all topics together.
        """
        self._is_closed = True
        with self._lock:
            publisher, topic = self._publisher, self._topic
            self._publisher = self._topic = None
        if publisher is not None:
            if topic is not None:
                if rospy.core.is_shutdown_requested():  # rospy closes all topics
                    return
                topic.finish()
            publisher.unregister()

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Send a message, given as an object or by its fields, as with ``rospy.Publisher``.

        :raises TypeError: if the arguments are not a message of the topic's type, nor its fields
        :raises rospy.ROSSerializationException: if the value of a field does not fit its type
        :raises rospy.ROSException: if the publisher is closed or the node not initialised;
            never because the node is shutting down
        """
        topic = self._topic
        if topic is not None and len(args) == 1 and type(args[0]) is self.data_class and not kwds:
            topic.publish_all(args)
            return
        is_kept = self._publisher is None and self._latch and not self._is_closed
        message = self._to_message(args, kwds)
        if is_kept:
            with self._lock:
                if self._publisher is None:  # otherwise it has just been opened
                    self._first = message
                    return
        publisher = self._publisher
        if publisher is not None:
            publisher.publish(message)
        elif self._is_closed:
            raise rospy.ROSException(f"publish() to a closed publisher of {self.resolved_name}")

    def _to_message(self, args: Sequence[Any], kwds: Mapping[str, Any]) -> Any:
        """Return the message that :meth:`publish` is called with, or one of the given fields.

        Fields are checked here: a topic without subscribers never serializes its messages.
        """
        if len(args) == 1 and type(args[0]) is self.data_class and not kwds:
            return args[0]
        what = f"topic {self.resolved_name}"
        if len(args) == 1 and isinstance(args[0], type):
            must = f"must be a message, such as {self.data_class.__name__}()"
            raise TypeError(f"{what}: refused the class {args[0].__name__}: {must}")
        message = rospy.msg.args_kwds_to_message(self.data_class, args, kwds)
        if not (args and message is args[0]):
            try:
                message.serialize(io.BytesIO())
            except genpy.SerializationError as error:
                raise InvalidField(f"{what}: refused {args or kwds!r:.80}: {error}") from None
        return message

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send several messages in one delivery, which takes hardly longer than one message.

        :param messages: messages of the publisher's class, oldest first
        :raises rospy.ROSSerializationException: as :meth:`publish`; no message is sent then
        :raises rospy.ROSException: as :meth:`publish`
        """
        topic = self._topic
        if topic is None:
            for message in messages:
                self.publish(message)
        elif messages:
            topic.publish_all(messages)

    def latch_all(self, messages: Sequence[Any]) -> None:
        """Set the messages for later subscribers of a latched topic, in place of the last one.

        Call this before the newest of them is published, so that a subscriber that connects
        meanwhile gets it. With rospy's own queues, later subscribers still get the last message;
        those in the same process get no earlier messages.

        :param messages: messages of the publisher's class; empty for the last one sent from now on
        """
        topic = self._topic
        if topic is not None:
            topic.latch_all(messages)

    def get_num_connections(self, in_process: bool = True) -> int:
        """Return the number of subscribing nodes.

        :param in_process: whether to count this process, if it subscribes to the topic
        """
        publisher, topic = self._publisher, self._topic
        if topic is not None and not in_process:
            return len(topic.links())
        return int(publisher.get_num_connections()) if publisher is not None else 0

    def subscribers(self) -> Set[str]:
        """Return the names of the connected subscribing nodes, with this process's own."""
        publisher, topic = self._publisher, self._topic
        if topic is None:  # rospy's own queues
            connections = list(publisher.impl.connections) if publisher is not None else []
            return {str(one.header.get("callerid")) for one in connections if one.header}
        links = topic.links()
        names = {link.name for link in links}
        is_own = self.get_num_connections() > len(links)
        return names | {rospy.get_name()} if is_own else names

    def statistics(self) -> List[SubscriberStatistics]:
        """Return the counters of the connected subscribers.

        :returns: one entry per subscriber; empty with rospy's own queues
        """
        topic, now = self._topic, time.monotonic()
        links = topic.links() if topic is not None else []
        return [
            SubscriberStatistics(
                link.name, link.sent, link.lost, link.takes_nothing(now), link.unsent_bytes
            )
            for link in links
        ]
