"""Publishers that send at once, and that a stalled subscriber cannot hold up."""

from typing import Any, List, NamedTuple, Sequence

import genpy
import rospy

from nodekit.rospy_internals import publishers

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


class Publisher(rospy.Publisher):
    """A ``rospy.Publisher`` without a queue.

    :meth:`publish` returns when the message is with the operating system: the lowest latency, and
    no loss to a subscriber that reads. One that does not holds up one call, by at most 50 ms; from
    then on it gets the newest message only, in the background, until it reads again. What it loses
    is counted and reported, and what it gets is whole. May be used from several threads.

    :param name: topic
    :param data_class: message class
    :param latch: whether later subscribers get the last message
    """

    def __init__(self, name: str, data_class: type, latch: bool = False) -> None:
        mismatch = publishers.publisher_mismatch()
        if mismatch:
            rospy.logwarn_once("publishing with queues, as this rospy is not known: %s", mismatch)
        self._sends_at_once = not mismatch and publishers.send_at_once(name, data_class, latch)
        super().__init__(name, data_class, latch=latch, queue_size=FALLBACK_QUEUE_SIZE)

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Send a message, given itself or by its fields, as with ``rospy.Publisher``.

        :raises rospy.ROSSerializationException: if a field has a value that does not fit
        :raises rospy.ROSException: if the publisher is unregistered or the node not initialised;
            never because the node is shutting down
        """
        if self._sends_at_once and not kwds and len(args) == 1 and type(args[0]) is self.data_class:
            self.publish_all(args)
        else:
            super().publish(*args, **kwds)

    def publish_all(self, messages: Sequence[Any]) -> None:
        """Send several messages in one go, which takes hardly longer than one.

        :param messages: what to send, of the publisher's class, oldest first
        :raises rospy.ROSSerializationException: as :meth:`publish`; none is sent then
        :raises rospy.ROSException: as :meth:`publish`
        """
        if not self._sends_at_once:
            for message in messages:
                self.publish(message)
            return
        if self.impl is None:
            raise rospy.ROSException("publish() to an unregistered publisher")
        if messages:
            try:
                self.impl.publish_all(messages)
            except genpy.SerializationError as error:
                raise rospy.ROSSerializationException(str(error)) from error

    def statistics(self) -> List[SubscriberStatistics]:
        """Tell how the present subscribers fare.

        :returns: one entry per subscriber; none where rospy's own queues are in use
        """
        links = self.impl.links() if self._sends_at_once else []
        return [
            SubscriberStatistics(link.name, link.sent, link.lost, link.stalled) for link in links
        ]
