"""Topic subscription with one call for all messages that arrive together."""

import time
from typing import Any, Callable, List, Optional, Set

import rospy

from nodekit.argument_checks import check_message_class
from nodekit.rospy_internals import incoming_topic, latched, registry
from nodekit.rospy_internals.large_arrays import with_views


class Subscription:
    """Subscription to a topic.

    The callback mostly gets one message, and several after a busy moment. No message is dropped
    here.

    :param name: topic, resolved
    :param data_class: message class
    :param receive: called with a list of messages, oldest first, and whether the calling thread may
        be blocked; from a thread for each publisher, or the publishing thread of this process
    :param newest_only: whether only the newest messages matter, so that connections are read until
        they are empty
    :param views: whether arrays of bytes are read-only views
    :raises TypeError: if the class is not a message class
    """

    def __init__(
        self,
        name: str,
        data_class: type,
        receive: Callable[[List[Any], bool], None],
        newest_only: bool = False,
        views: bool = False,
    ) -> None:
        check_message_class(data_class, name)
        self.resolved_name = name
        self._data_class, self._receive = data_class, receive
        self._newest_only, self._views = newest_only, views
        if views:
            self._receive = lambda messages, may_wait: receive(
                list(map(with_views, messages)), may_wait
            )
        self._subscriber: Optional[rospy.Subscriber] = None
        self._is_closed = self._is_late = False

    def open(self) -> None:
        """Subscribe, unless the subscription is closed."""
        if self._is_closed:
            return
        mismatch = incoming_topic.subscriber_mismatch()
        if mismatch:
            rospy.logwarn_once("unsupported rospy version: receiving one by one: %s", mismatch)
        name, data_class = self.resolved_name, self._data_class
        before = registry.name_before_remapping(name)
        with registry.topic_lock():
            self._is_late = latched.is_subscribed(name)
            if not mismatch and incoming_topic.receive_in_batches(
                name, data_class, self._receive, self._newest_only, self._views
            ):
                self._subscriber = rospy.Subscriber(before, data_class, tcp_nodelay=True)
            else:
                self._subscriber = rospy.Subscriber(
                    before,
                    data_class,
                    lambda message: self._receive([message], True),
                    tcp_nodelay=True,
                )
        if self._is_closed:  # by another thread meanwhile
            self.close()

    def receive_latched(self) -> None:
        """Pass on the topic's latched messages; call this once, after :meth:`open`."""
        latched.receive_latched(self.resolved_name, self._receive, self._is_late)

    def get_num_connections(self) -> int:
        """Return the number of publishing nodes, including this process if it publishes."""
        subscriber = self._subscriber
        return int(subscriber.get_num_connections()) if subscriber is not None else 0

    def publishers(self) -> Set[str]:
        """Return the names of the connected publishing nodes, including this process's.

        A connection counts once its publisher has answered, and sends all later messages.
        """
        subscriber = self._subscriber
        return incoming_topic.publishers_of(subscriber.impl) if subscriber is not None else set()

    def close(self) -> None:
        """Unsubscribe."""
        self._is_closed = True
        subscriber, self._subscriber = self._subscriber, None
        if subscriber is not None:
            incoming_topic.stop_receiving(self.resolved_name, self._receive)
            subscriber.unregister()


class LatestMessage:
    """Latest message of a topic, without a callback.

    :param name: topic, resolved
    :param data_class: message class

    :ivar message: the message; None before the first
    """

    def __init__(self, name: str, data_class: type) -> None:
        self.message: Any = None
        self.subscription = Subscription(name, data_class, self._receive)
        self._arrived_at = float("-inf")

    @property
    def age(self) -> float:
        """Time since the arrival of the message by the monotonic clock [s]; infinite before it."""
        return time.monotonic() - self._arrived_at

    def _receive(self, messages: List[Any], _may_wait: bool) -> None:
        self.message = messages[-1]
        self._arrived_at = time.monotonic()
