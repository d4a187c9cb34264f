"""What was latched on a topic before somebody subscribes to it."""

import io
from typing import Any, Callable

import rospy
import rospy.topics
from rospy.impl.registration import Registration, get_topic_manager

from nodekit.rospy_internals.incoming_topic import (
    BatchCallback,
    IncomingTopic,
    subscriber_mismatch,
)


def is_heard(name: str) -> bool:
    """Tell whether a topic is heard already, by another subscription of this process.

    :param name: topic, resolved
    """
    return isinstance(get_topic_manager().get_subscriber_impl(name), IncomingTopic)


def receive_latched(name: str, callback: BatchCallback, is_late: bool) -> None:
    """Hand over what is latched on a topic.

    :param name: topic, resolved
    :param callback: what to call
    :param is_late: whether the topic was heard already: what its connections have brought counts
        too then
    """
    manager = get_topic_manager()
    topic, publisher = manager.get_subscriber_impl(name), manager.get_publisher_impl(name)
    if not isinstance(topic, IncomingTopic):
        return
    messages = [one.latch for one in topic.connections if is_late and one.latch is not None]
    if topic.hears(publisher) and publisher.latch is not None:
        buffer = io.BytesIO()
        publisher.latch.serialize(buffer)
        messages += topic.copies([buffer.getvalue()], publisher.local_header)
    if messages:
        callback(messages, False)


def subscribe_without_loss(name: str, data_class: type, callback: Callable[[Any], None]) -> Any:
    """Subscribe as with rospy alone, but miss nothing that comes at once.

    rospy registers a topic before the callback is in place, so that on a busy machine a latched
    message may come in between, and is lost for good.

    :param name: topic, resolved
    :param data_class: message class
    :param callback: called with each message
    :returns: the ``rospy.Subscriber``
    """
    manager = get_topic_manager()
    with manager.lock:
        if subscriber_mismatch() or manager.get_subscriber_impl(name) is not None:
            return rospy.Subscriber(name, data_class, callback)
        topic = rospy.topics._SubscriberImpl(name, data_class)
        topic.add_callback(callback, None)
        manager._add(topic, manager.subs, Registration.SUB)
        subscriber = rospy.Subscriber(name, data_class)
        subscriber.callback, subscriber.callback_args = callback, None  # what its end takes back
        return subscriber
