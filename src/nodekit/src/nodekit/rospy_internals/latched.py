"""Delivery of latched messages to an additional subscription of a topic in the same process."""

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


def is_subscribed(name: str) -> bool:
    """Return whether this process subscribes to a topic already.

    :param name: topic, resolved
    """
    return isinstance(get_topic_manager().get_subscriber_impl(name), IncomingTopic)


def receive_latched(name: str, callback: BatchCallback, is_late: bool) -> None:
    """Pass on the latched messages of a topic.

    :param name: topic, resolved
    :param callback: called with the messages
    :param is_late: whether the process subscribed to the topic before, so that the latched messages
        of its connections have arrived already
    """
    manager = get_topic_manager()
    topic, publisher = manager.get_subscriber_impl(name), manager.get_publisher_impl(name)
    if not isinstance(topic, IncomingTopic):
        return
    messages = [one.latch for one in topic.connections if is_late and one.latch is not None]
    if topic.receives_from(publisher) and publisher.latch is not None:
        buffer = io.BytesIO()
        publisher.latch.serialize(buffer)
        messages += topic.copies([buffer.getvalue()], publisher.local_header)
    if messages:
        callback(messages, False)


def subscribe_without_loss(name: str, data_class: type, callback: Callable[[Any], None]) -> Any:
    """Subscribe as with rospy alone, without losing a message that arrives immediately.

    rospy registers a topic before it adds the callback, so that on a busy machine a latched message
    may arrive in between, and is lost.

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
        subscriber.callback, subscriber.callback_args = callback, None  # removed by unregister()
        return subscriber
