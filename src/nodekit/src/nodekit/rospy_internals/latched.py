"""What was latched on a topic before a subscription of it, and no connection brings again."""

import io

from rospy.impl.registration import get_topic_manager

from nodekit.rospy_internals.subscribers import BatchCallback, IncomingTopic


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
        messages += topic.copies([buffer.getvalue()])
    if messages:
        callback(messages, False)
