"""Bridge of one topic, ROS 1 to ROS 2 or back, subscribed on demand."""

import contextlib
import io
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Set, Tuple

import rospy
from rclpy.node import Node as Ros2Node

from nodekit import Node, ReentrantCallbackGroup, Throttle
from ros2_bridge.health.topic_health import TopicCounts
from ros2_bridge.ros2.graph import Topic
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.ros2.received_message import ReceivedMessage
from ros2_bridge.rules.active_pairs import BridgedResources
from ros2_bridge.rules.rates import RateLimit
from ros2_bridge.rules.settings import QosProfiles, QosProfile
from ros2_bridge.topics.publishers import TopicPublishers
from ros2_bridge.topics.static_transforms import JOINED_TYPE, StaticTransforms
from ros2_bridge.types.codec import ConversionError
from ros2_bridge.types.type_registry import MessageType

#: Most publishers of a ROS 2 topic whose sequence numbers are tracked.
_MOST_SENDERS = 1000
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 1.0


def serialized(message: Any) -> bytes:
    """Return the bytes of a ROS 1 message.

    :param message: usually raw; of another class on topics that rospy itself subscribes to, such
        as /clock, because a process's first subscription sets the class for all
    """
    raw: Optional[bytes] = getattr(message, "_buff", None)
    if raw is None:
        buffer = io.BytesIO()
        message.serialize(buffer)
        raw = buffer.getvalue()
    return raw


class PairCounters:
    """Counters of a pair: messages passed, lost, rejected, and dropped by the maximum rate."""

    def __init__(self) -> None:
        self.passed = self.lost = self.refused = self.thinned = 0


class OnDemandSubscription:
    """Subscription that exists only while it is needed.

    :param subscribe: creates it, and returns a function that ends it
    """

    def __init__(self, subscribe: Callable[[], Callable[[], None]]) -> None:
        self._subscribe = subscribe
        self._unsubscribe: Optional[Callable[[], None]] = None

    def switch(self, is_needed: bool) -> None:
        """Start or end the subscription, as needed."""
        if is_needed and self._unsubscribe is None:
            self._unsubscribe = self._subscribe()
        elif not is_needed and self._unsubscribe is not None:
            self._unsubscribe()
            self._unsubscribe = None


class LatchedMessage(NamedTuple):
    """Latest message of a transient-local ROS 2 publisher, as a ROS 1 message."""

    message: Any

    def close(self) -> None:
        """Do nothing: there are no resources."""


class LatchedTransforms(NamedTuple):
    """Static transforms that a ROS 1 node latches.

    :param header: of its connection, which is another one after a restart of the node
    :param transforms: all that this connection has brought
    """

    header: Any
    transforms: StaticTransforms

    def close(self) -> None:
        """Do nothing: there are no resources."""


class TopicToRos2:
    """ROS 1 topic in ROS 2.

    The publisher exists from the beginning, the subscription only while there are subscribers in
    ROS 2, and as long as a latched message exists, so that late subscribers receive it.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param topic, other: name in ROS 1 and in ROS 2

    :ivar publishers: its publishers in ROS 2
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        topic: str,
        other: str,
        kind: MessageType,
        qualities: QosProfiles,
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._node, self._participant, self.topic, self.kind = node, participant, topic, kind
        self._other, self._qualities = other, qualities
        self.count, self.limit = PairCounters(), RateLimit()
        self._subscription = OnDemandSubscription(self._subscribe)
        #: Latched transforms by node.
        self._transforms: BridgedResources[str, LatchedTransforms] = BridgedResources()
        self.publishers = TopicPublishers(participant, self._make_publisher, self._quality)

    def _quality(self, latched: bool, size: int) -> QosProfile:
        # ROS 1 latches a single message.
        return self._qualities.of(self.topic, latched, at_least=1 if latched else 0, size=size)

    def _make_publisher(self, owner: Ros2Node, quality: QosProfile) -> Any:
        return self._participant.create_publisher(owner, self.kind.cls, self._other, quality)

    def _subscribe(self) -> Callable[[], None]:
        scope = self._node.create_scope()
        scope.create_batch_subscription(
            self.topic, self.kind.raw, self._forward, group=ReentrantCallbackGroup()
        )
        return scope.close

    def forward_while(self, is_heard: bool) -> None:
        """Subscribe to the topic, or unsubscribe unless a message of it is latched.

        :param is_heard: whether it has subscribers in ROS 2
        """
        is_kept = self._qualities.of(self.topic).latched or self.publishers.has_latched()
        self._subscription.switch(is_heard or is_kept)

    def _forward(self, messages: List[Any]) -> None:
        for message in messages:
            if rospy.is_shutdown():
                return
            header = message._connection_header
            if header.get("callerid") == self._node.name:
                continue  # the bridge's own messages, from ROS 2
            is_latched = header.get("latching") == "1"
            if not (is_latched or self.limit.passes(time.monotonic())):
                self.count.thinned += 1
                continue
            try:
                data = self.kind.codec.to_cdr(serialized(message))
                if is_latched and self.kind.ros1 == JOINED_TYPE:
                    data = self.kind.codec.to_cdr(self._joined(header, serialized(message)))
            except ConversionError as error:
                self.count.refused += 1
                if self._throttle.is_due():
                    rospy.logwarn(f"{self.topic} to ROS 2: {error}")
                continue
            self.publishers.publish(header.get("callerid", ""), data, is_latched)
            self.count.passed += 1

    def counts(self) -> TopicCounts:
        """Return the current counters."""
        found = self.count
        return TopicCounts(
            found.passed,
            refused=found.refused,
            thinned=found.thinned,
            held=self.publishers.held_at_most(),
        )

    def _joined(self, header: Any, data: bytes) -> bytes:
        """Return a message with all transforms that a connection has brought so far.

        :param header: of the connection
        :param data: valid message, the latest one
        """
        caller = header.get("callerid", "")
        latched = self._transforms.get(caller)
        if latched is None or latched.header is not header:
            latched = self._transforms[caller] = LatchedTransforms(header, StaticTransforms())
        return latched.transforms.join(data)

    def forget_all_but(self, callers: Set[str]) -> None:
        """Forget the transforms of nodes that have ended.

        :param callers: the nodes that publish the topic; empty after a restart of the master
        """
        if callers:
            self._transforms.close_missing(callers)

    def close(self) -> None:
        """Close publishers and subscription."""
        self._subscription.switch(False)
        self.publishers.close()


class TopicToRos1:
    """ROS 2 topic in ROS 1.

    The publisher exists from the beginning, the subscription only while there are subscribers in
    ROS 1, or always if the topic is transient-local. Late subscribers then receive the latest
    message of each transient-local publisher.

    If only some publishers are transient-local, there are two subscriptions: a transient-local one,
    which only they match, and a volatile one for the others.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param topic, other: name in ROS 1 and in ROS 2
    :param found: the topic in ROS 2
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        topic: str,
        other: str,
        kind: MessageType,
        qualities: QosProfiles,
        found: Topic,
    ) -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._participant, self.topic, self._other, self.kind = participant, topic, other, kind
        self._qualities, self._found = qualities, found
        self._wanted = self._wanted_qualities()
        self.count, self.limit = PairCounters(), RateLimit()
        self._seq = 0
        self._last: Dict[bytes, int] = {}
        self._lock = threading.Lock()
        self._kept: BridgedResources[bytes, LatchedMessage] = BridgedResources()
        self._scope = node.create_scope()
        self._publisher = self._scope.create_publisher(topic, kind.raw, latch=found.latched)
        #: Existing subscriptions by transient-local, each with a function that ends it.
        self._subscriptions: Dict[bool, Tuple[QosProfile, Callable[[], None]]] = {}
        #: Whether each publisher is transient-local, if known.
        self._latching: Dict[bytes, bool] = {}
        try:
            self.forward_if_heard()
        except BaseException:
            self.close()
            raise

    def _wanted_qualities(self) -> Dict[bool, QosProfile]:
        """Return the needed subscriptions, by whether they are transient-local."""
        wanted: Dict[bool, QosProfile] = {}
        for latched, may_lose in self._found.offers.items():
            quality = self._qualities.of(self.topic, latched, may_lose)
            other = wanted.get(quality.latched, quality)  # if the user set it
            may_lose = quality.best_effort or other.best_effort
            wanted[quality.latched] = quality._replace(best_effort=may_lose)
        return wanted

    def forward_if_heard(self) -> None:
        """Subscribe to the topic, or unsubscribe."""
        is_heard = self._found.latched or self._publisher.get_num_connections(in_process=False) > 0
        self._switch(self._wanted if is_heard else {})

    def _switch(self, wanted: Mapping[bool, QosProfile]) -> None:
        for kept, (quality, end) in list(self._subscriptions.items()):
            if wanted.get(kept) != quality:
                del self._subscriptions[kept]
                end()
        for kept, quality in wanted.items():
            if kept not in self._subscriptions:
                self._last.clear()
                forward = partial(self._forward, kept)
                end = self._participant.create_subscription(
                    self.kind.cls, self._other, quality, forward
                )
                self._subscriptions[kept] = quality, end

    def fits(self, found: Topic) -> bool:
        """Return whether the other publishers' durability is unchanged."""
        return self._found.latched == found.latched

    def follow_publishers(self, found: Topic) -> None:
        """Adapt the subscriptions to the current publishers; drop messages of former publishers.

        :param found: the topic in ROS 2
        """
        if found.offers not in ({}, self._found.offers):
            self._found = found
            self._wanted = self._wanted_qualities()
        self.forget_all_but(found.senders)

    def _is_latched(self, sender: bytes) -> bool:
        if sender not in self._latching:
            self._latching = self._participant.latching(self._other)
        return self._latching.get(sender, False)

    def _forward(self, kept: bool, arrived: List[ReceivedMessage]) -> None:
        """Publish received messages.

        :param kept: whether they are from the transient-local subscription
        """
        messages = []
        latest: Dict[bytes, LatchedMessage] = {}
        for data, sender, number in arrived:
            if self._participant.is_own(sender):
                continue  # the bridge's own messages, from ROS 1
            is_latched = self._found.latched and (kept or self._is_latched(sender))
            if is_latched and not kept and True in self._subscriptions:
                continue  # the other subscription receives it, too
            self._count_lost(sender, number)
            if not (is_latched or self.limit.passes(time.monotonic())):
                self.count.thinned += 1
                continue
            message = self.kind.raw()
            try:
                message._buff = self.kind.codec.to_ros1(data, self._seq)
            except ConversionError as error:
                self.count.refused += 1
                if self._throttle.is_due("conversion"):
                    rospy.logwarn(f"{self.topic} to ROS 1: {error}")
                continue
            self._seq += 1
            messages.append(message)
            if is_latched:
                latest[sender] = LatchedMessage(message)
        if messages:
            if latest:
                self._keep(latest)
            with contextlib.suppress(rospy.ROSException):  # just closed
                self._publisher.publish_all(messages)
                self.count.passed += len(messages)
            if self._found.latched and not latest:
                self._keep({})  # otherwise the last message would stay latched

    def _keep(self, latest: Mapping[bytes, LatchedMessage]) -> None:
        with self._lock:
            self._kept.update(latest)
            self._publisher.latch_all([kept.message for kept in self._kept.values()])

    def forget_all_but(self, senders: Set[bytes]) -> None:
        """Drop the latched messages of publishers that have disappeared.

        :param senders: the existing publishers
        """
        with self._lock:
            before = len(self._kept)
            self._kept.close_missing(senders)
            if len(self._kept) < before:
                self._publisher.latch_all([kept.message for kept in self._kept.values()])

    def _count_lost(self, sender: bytes, number: Optional[int]) -> None:
        """Count lost messages, by the gaps in a publisher's sequence numbers."""
        if number is None:
            return
        before = self._last.get(sender)
        if before is not None and number > before + 1:
            lost = number - before - 1
            self.count.lost += lost
            if self._throttle.is_due("lost"):
                rospy.logwarn(f"{self.topic}: {lost} messages were lost on the way from ROS 2")
        if len(self._last) >= _MOST_SENDERS:
            self._last.clear()
        self._last[sender] = number

    def counts(self) -> TopicCounts:
        """Return the current counters."""
        found, subscribers = self.count, self._publisher.statistics()
        return TopicCounts(
            found.passed,
            found.lost,
            found.refused,
            sum(one.lost for one in subscribers),
            found.thinned,
            sum(one.held_bytes for one in subscribers),
        )

    def close(self) -> None:
        """Close publisher and subscriptions."""
        self._switch({})
        self._scope.close()
