"""Publishers that send at once, and that a stalled subscriber cannot hold up."""

import threading
from typing import Any, List, NamedTuple, Optional, Sequence

import rospy

from nodekit.rospy_internals import outgoing_topic, registry
from nodekit.validation import check_message_class

#: queue of the plain publisher that stands in where rospy's internals are not as expected
FALLBACK_QUEUE_SIZE = 100


class SubscriberStatistics(NamedTuple):
    """What became of the messages to one subscriber."""

    #: name of the subscribing node
    node: str
    #: messages sent
    sent: int
    #: messages dropped because it did not read
    lost: int
    #: whether it is being left behind now
    stalled: bool


class Publisher:
    """A topic that a node publishes, without a queue.

    :meth:`publish` returns when the message is with the operating system: the lowest latency, and
    no loss to a subscriber that reads. One that does not holds up one call, by at most 50 ms; from
    then on it gets the newest message only, in the background, until it reads again. What it loses
    is counted and reported, and what it gets is whole. May be used from several threads.

    Before it is open nobody can hear it: of what is published then the last message is kept, if it
    is latched, and sent on opening.

    :param name: topic, resolved
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    :param lifespan: for how long they get it where it is not latched, s: a node that starts a
        moment later does not have to wait for the next one. Not in the same process, where the
        subscriptions are open before anything is published
    :raises TypeError: if the class is not that of a message
    """

    __slots__ = (
        "resolved_name",
        "data_class",
        "_latch",
        "_lifespan",
        "_first",
        "_publisher",
        "_topic",
        "_is_closed",
    )
    #: Held for a moment, where what is published is kept, or from then on sent; one for all.
    _lock = threading.Lock()

    def __init__(
        self, name: str, data_class: type, latch: bool = False, lifespan: float = 0.0
    ) -> None:
        check_message_class(data_class, name)
        self.resolved_name = name
        self.data_class = data_class
        self._latch = latch
        self._lifespan = lifespan
        self._first: Any = None
        self._publisher: Optional[rospy.Publisher] = None
        self._topic: Optional[outgoing_topic.OutgoingTopic] = None
        self._is_closed = False

    def open(self) -> None:
        """Advertise it, unless it was closed."""
        if self._is_closed:
            return
        mismatch = outgoing_topic.publisher_mismatch()
        if mismatch:
            rospy.logwarn_once("unsupported rospy version: publishing with queues: %s", mismatch)
        name, data_class = self.resolved_name, self.data_class
        topic: Optional[outgoing_topic.OutgoingTopic] = None
        with registry.topic_lock():
            if not mismatch:
                topic = outgoing_topic.send_at_once(name, data_class, self._latch, self._lifespan)
            publisher = rospy.Publisher(
                registry.name_before_remapping(name),
                data_class,
                latch=self._latch,
                queue_size=FALLBACK_QUEUE_SIZE,
            )
        publisher.name = publisher.resolved_name = name  # rospy has made copies
        while True:  # another thread may publish meanwhile, and what is latched is the newest
            with self._lock:
                first, self._first = self._first, None
                if first is None:
                    self._publisher, self._topic = publisher, topic
                    break
            if topic is not None:
                topic.publish_all((first,))
            else:
                publisher.publish(first)
        if self._is_closed:  # by another thread, meanwhile
            self.close()

    def close(self) -> None:
        """Publish no longer."""
        self._is_closed = True
        with self._lock:
            publisher, self._publisher, self._topic = self._publisher, None, None
        if publisher is not None:
            publisher.unregister()

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Send a message, given itself or by its fields, as with ``rospy.Publisher``.

        :raises rospy.ROSSerializationException: if a field has a value that does not fit
        :raises rospy.ROSException: if the publisher is closed or the node not initialised;
            never because the node is shutting down
        """
        topic = self._topic
        if topic is not None and len(args) == 1 and type(args[0]) is self.data_class and not kwds:
            topic.publish_all(args)
            return
        if self._publisher is None and self._latch and not self._is_closed:
            message = rospy.msg.args_kwds_to_message(self.data_class, args, kwds)
            with self._lock:
                if self._publisher is None:
                    self._first = message
                    return
            args, kwds = (message,), {}  # it was opened just now
        publisher = self._publisher
        if publisher is not None:
            publisher.publish(*args, **kwds)
        elif self._is_closed:
            raise rospy.ROSException(f"publish() to a closed publisher of {self.resolved_name}")

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send several messages in one go, which takes hardly longer than one.

        :param messages: what to send, of the publisher's class, oldest first
        :raises rospy.ROSSerializationException: as :meth:`publish`; none is sent then
        :raises rospy.ROSException: as :meth:`publish`
        """
        topic = self._topic
        if topic is None:
            for message in messages:
                self.publish(message)
        elif messages:
            topic.publish_all(messages)

    def latch_all(self, messages: Sequence[Any]) -> None:
        """Let later subscribers of a latched topic get these, in place of the last that was sent.

        To be called before the newest of them is published, so that nobody misses it who comes
        meanwhile. Where rospy's own queues are in use, it is the last message all the same; those
        in the same process get nothing from before.

        :param messages: of the publisher's class; none for the last that is sent from now on
        """
        topic = self._topic
        if topic is not None:
            topic.latch_all(messages)

    def get_num_connections(self) -> int:
        """Tell how many subscribers are connected; those in the same process need no connection."""
        publisher = self._publisher
        return int(publisher.get_num_connections()) if publisher is not None else 0

    def statistics(self) -> List[SubscriberStatistics]:
        """Tell how the present subscribers fare.

        :returns: one entry per subscriber; none where rospy's own queues are in use
        """
        links = self._topic.links() if self._topic is not None else []
        return [
            SubscriberStatistics(link.name, link.sent, link.lost, link.stalled) for link in links
        ]
