"""Topics of a board in ROS: publishers and subscribers."""

from functools import partial
from typing import Any

import rospy

from nodekit import NodeScope, ReentrantCallbackGroup
from serial_link.endpoints.types import decode, message_class
from serial_link.host.baud_pacing import explain_drop
from serial_link.host.counters import TOO_LARGE, Counters
from serial_link.link.board_link import BoardLink
from serial_link.link.throttled_log import ThrottledLog
from serial_link.negotiation.topic_table import Endpoint

_WARN_EVERY_S = 10.0
#: Most messages held for a subscriber that does not read. With a limit, publishing does not block.
_MOST_HELD = 200


class PublishedTopic:
    """Topic that the board publishes.

    :param scope: creates the publisher
    :param endpoint: of the board
    :raises TypeRefused: if the board's type differs from the installed one
    """

    def __init__(self, scope: NodeScope, endpoint: Endpoint) -> None:
        assert endpoint.incoming is not None
        self._class = message_class(endpoint.type, endpoint.incoming.md5sum)
        self._publisher = scope.create_publisher(endpoint.name, self._class, queue_size=_MOST_HELD)

    def update(self, endpoint: Endpoint) -> None:
        """IDs changed: nothing to do."""

    def receive(self, payload: bytes) -> None:
        """Publish a message of the board.

        :raises MalformedMessage: if it is malformed
        """
        self._publisher.publish(decode(self._class, payload))

    def on_sync(self) -> None:
        """Board synchronized: nothing to do."""

    def on_lost(self, why: str) -> None:
        """Board lost: nothing to do."""


class SubscribedTopic:
    """Topic that the board subscribes to. Its messages are passed on without decoding.

    A restarted board receives latched messages again, like a new subscriber.

    :param scope: creates the subscription
    :param endpoint: of the board
    :param link: sends to the board
    :param counters: counts messages that are too large
    :raises TypeRefused: if the board's type differs from the installed one
    """

    def __init__(
        self, scope: NodeScope, endpoint: Endpoint, link: BoardLink, counters: Counters
    ) -> None:
        assert endpoint.outgoing is not None
        self._link, self._counters, self._info = link, counters, endpoint.outgoing
        self._throttled_log = ThrottledLog(_WARN_EVERY_S)
        self._scope, self._topic = scope, endpoint.name
        self._name = scope.resolve(endpoint.name)
        data_class = message_class(endpoint.type, self._info.md5sum)
        kept = ("_type", "_md5sum", "_full_text", "_has_header")
        attributes = {name: getattr(data_class, name) for name in kept}
        self._raw = type("Raw", (rospy.AnyMsg,), {**attributes, "__slots__": []})
        self._subscriptions = scope.create_scope()
        self._is_replaced = False
        self._subscribe()

    def update(self, endpoint: Endpoint) -> None:
        """Update the topic's id and buffer size."""
        assert endpoint.outgoing is not None
        self._info = endpoint.outgoing

    def receive(self, payload: bytes) -> None:
        """Ignore it: the board only subscribes."""

    def on_sync(self) -> None:
        """Subscribe again for a restarted board; the topic stays registered."""
        before, self._subscriptions = self._subscriptions, self._scope.create_scope()
        # Meanwhile the new subscription delivers latched messages, and the old one all others.
        self._is_replaced = True
        self._subscribe()
        self._is_replaced = False  # before closing: a message may arrive twice, but is never lost
        before.close()

    def on_lost(self, why: str) -> None:
        """Board lost: nothing to do."""

    def _subscribe(self) -> None:
        on_message, group = partial(self._on_message, self._subscriptions), ReentrantCallbackGroup()
        self._subscriptions.create_subscription(self._topic, self._raw, on_message, group=group)

    def _on_message(self, scope: NodeScope, message: Any) -> None:
        payload, info = message._buff, self._info
        is_latched = message._connection_header.get("latching") == "1"
        is_new = scope is self._subscriptions
        is_due = is_new if is_latched else not (is_new and self._is_replaced)
        if not is_due or not self._fits(payload):
            return
        problem = explain_drop(len(payload), self._link.baud)
        if problem:
            self._throttled_log.log(rospy.logwarn, f"{self._name}: {problem}", "time")
        if is_latched:
            self._link.send_latched(info, payload)
        else:
            self._link.send(info, payload)

    def _fits(self, payload: bytes) -> bool:
        """Return whether a message fits into the board's buffer; if not, count and log it."""
        size = self._info.buffer_size
        if len(payload) <= size:
            return True
        self._counters.add(TOO_LARGE)
        self._throttled_log.log(
            rospy.logwarn,
            f"{self._name}: a message of {len(payload)} bytes is not sent: the board's buffer "
            f"has {size}",
            "size",
        )
        return False
