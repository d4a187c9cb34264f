"""One topic, one way. What has no subscribers on the other side is not fetched."""

import contextlib
import threading
from typing import Any, Callable, Dict, List, Optional, Set

import rospy

from nodekit import Node
from ros2_bridge.ros2.graph import Topic
from ros2_bridge.ros2.side import Ros2
from ros2_bridge.ros2.taking import Arrived
from ros2_bridge.rules.settings import Qualities
from ros2_bridge.types.codec import ConversionError
from ros2_bridge.types.types import MessageType

#: Most senders of a topic of ROS 2 whose messages are counted, until it is begun anew.
_MOST_SENDERS = 1000


class Count:
    """How much went through a pair, and what was lost."""

    def __init__(self) -> None:
        self.passed = self.lost = self.refused = 0


class OnDemand:
    """A subscription that is there only while it is needed.

    :param subscribe: makes it, and returns what ends it
    """

    def __init__(self, subscribe: Callable[[], Callable[[], None]]) -> None:
        self._subscribe = subscribe
        self._unsubscribe: Optional[Callable[[], None]] = None

    def switch(self, is_needed: bool) -> None:
        """Begin or end it, where that is due."""
        if is_needed and self._unsubscribe is None:
            self._unsubscribe = self._subscribe()
        elif not is_needed and self._unsubscribe is not None:
            self._unsubscribe()
            self._unsubscribe = None


class TopicToRos2:
    """A topic of ROS 1 in ROS 2.

    It is published from the beginning, and subscribed to while it has subscribers in ROS 2.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param topic, other: name in ROS 1 and in ROS 2
    """

    def __init__(
        self,
        node: Node,
        side: Ros2,
        topic: str,
        other: str,
        kind: MessageType,
        qualities: Qualities,
    ) -> None:
        self._node, self._side, self.topic, self.kind = node, side, topic, kind
        self._other, self._qualities = other, qualities
        self.count = Count()
        self._lock = threading.Lock()
        self._latches: Dict[str, bytes] = {}
        self._callers: Set[str] = set()
        self._subscription = OnDemand(self._subscribe)
        self._publisher = side.publisher(kind.cls, other, qualities.of(topic))

    def _subscribe(self) -> Callable[[], None]:
        made = self._node.lifetime()
        made.subscribe_batches(
            self.topic, self.kind.raw, self._forward, group=made.group(exclusive=False)
        )
        return made.close

    def forward_while(self, is_heard: bool, callers: Set[str]) -> None:
        """Subscribe to the topic, or no longer.

        :param is_heard: whether it has subscribers in ROS 2
        :param callers: who publishes it in ROS 1
        """
        self._callers = callers or self._callers  # none: the master has been restarted
        self._subscription.switch(is_heard)

    def _forward(self, messages: List[Any]) -> None:
        for message in messages:
            if rospy.is_shutdown():
                return
            header = message._connection_header
            if header.get("callerid") == self._node.name:
                continue  # what has come from ROS 2
            try:
                data = self.kind.codec.to_cdr(message._buff)
            except ConversionError as error:
                self.count.refused += 1
                rospy.logwarn_throttle(1.0, f"{self.topic} to ROS 2: {error}")
                continue
            if header.get("latching") == "1":
                self._latch(header.get("callerid", ""), data)
            else:
                self._publisher.publish(data)
            self.count.passed += 1

    def _latch(self, caller: str, data: bytes) -> None:
        """Publish so that those who come later get it too, the latest of each latching node."""
        with self._lock:
            is_new = caller not in self._latches
            if is_new:  # what nodes have left that are no more, is forgotten
                kept = {one: last for one, last in self._latches.items() if one in self._callers}
                self._latches = kept
            self._latches[caller] = data
            if not is_new:
                self._publisher.publish(data)
                return
            old = self._publisher
            qos = self._qualities.of(self.topic, latched=True, at_least=len(self._latches))
            self._publisher = self._side.publisher(self.kind.cls, self._other, qos)
            for last in self._latches.values():
                self._publisher.publish(last)
            self._side.destroy_publisher(old)

    def close(self) -> None:
        """End it."""
        self._subscription.switch(False)
        with self._lock:
            self._side.destroy_publisher(self._publisher)


class TopicToRos1:
    """A topic of ROS 2 in ROS 1.

    It is published from the beginning, and subscribed to while it has subscribers in ROS 1; where
    it is latched, always.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param topic, other: name in ROS 1 and in ROS 2
    :param found: how others publish it
    """

    def __init__(
        self,
        node: Node,
        side: Ros2,
        topic: str,
        other: str,
        kind: MessageType,
        qualities: Qualities,
        found: Topic,
    ) -> None:
        self._side, self.topic, self._other, self.kind = side, topic, other, kind
        self._qualities, self._found = qualities, found
        self.count = Count()
        self._seq = 0
        self._last: Dict[bytes, int] = {}
        self._made = node.lifetime()
        self._publisher = self._made.publisher(topic, kind.raw, latch=found.latched)
        self._subscription = OnDemand(self._subscribe)
        try:
            self.forward_if_heard()
        except BaseException:
            self.close()
            raise

    def _subscribe(self) -> Callable[[], None]:
        qos = self._qualities.of(self.topic, self._found.latched, self._found.best_effort)
        self._last.clear()
        return self._side.subscribe(self.kind.cls, self._other, qos, self._forward)

    def forward_if_heard(self) -> None:
        """Subscribe to the topic, or no longer."""
        self._subscription.switch(self._found.latched or self._publisher.get_num_connections() > 0)

    def fits(self, found: Topic) -> bool:
        """Tell whether others publish it as they did, as far as it matters."""
        mine = self._found
        return (mine.latched, mine.best_effort) == (found.latched, found.best_effort)

    def _forward(self, arrived: List[Arrived]) -> None:
        messages = []
        for data, sender, number in arrived:
            if self._side.is_ours(sender):
                continue  # what has come from ROS 1
            self._count_lost(sender, number)
            message = self.kind.raw()
            try:
                message._buff = self.kind.codec.to_ros1(data, self._seq)
            except ConversionError as error:
                self.count.refused += 1
                rospy.logwarn_throttle(1.0, f"{self.topic} to ROS 1: {error}")
                continue
            self._seq += 1
            messages.append(message)
        if messages:
            with contextlib.suppress(rospy.ROSException):  # it has just been closed
                self._publisher.publish_all(messages)
                self.count.passed += len(messages)

    def _count_lost(self, sender: bytes, number: Optional[int]) -> None:
        """Count what a publisher has numbered and what has not arrived."""
        if number is None:
            return
        before = self._last.get(sender)
        if before is not None and number > before + 1:
            lost = number - before - 1
            self.count.lost += lost
            rospy.logwarn_throttle(
                1.0, f"{self.topic}: {lost} messages were lost on the way from ROS 2"
            )
        if len(self._last) >= _MOST_SENDERS:
            self._last.clear()
        self._last[sender] = number

    def close(self) -> None:
        """End it."""
        self._subscription.switch(False)
        self._made.close()
