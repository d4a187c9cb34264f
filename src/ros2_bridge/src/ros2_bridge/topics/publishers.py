"""ROS 2 publishers of a ROS 1 topic, one for each publishing node."""

import threading
import time
from typing import Any, Callable, Mapping, Optional, Set

from rclpy.node import Node as Ros2Node

from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.active_pairs import BridgedResources
from ros2_bridge.rules.settings import QosProfile

MakePublisher = Callable[[Ros2Node, QosProfile], Any]
QualityOf = Callable[[bool, int], QosProfile]

#: Time until all subscribers have discovered a new publisher [s].
_KNOWN_S = 0.1
#: Stands for all nodes that are not shown in ROS 2 and do not latch.
_OTHERS = ""


class NodePublisher:
    """Publisher of a topic for one ROS 1 node, with its latched message, if any.

    Each publisher has its own history, so that other nodes' messages do not displace its message.

    :param participant: the bridge in ROS 2
    :param make: creates a publisher of a node with a quality of service
    :param quality: returns the quality, latched or not, for messages of a size [bytes]
    :param owner: the publishing ROS 2 node

    :ivar is_latched: whether late subscribers receive the latest message
    """

    def __init__(
        self, participant: Participant, make: MakePublisher, quality: QualityOf, owner: Ros2Node
    ) -> None:
        self._participant, self._make, self._quality_of = participant, make, quality
        self.owner, self.is_latched, self._size = owner, False, 0
        self._quality = quality(False, 0)
        self._publisher, self._latest = make(owner, self._quality), b""

    def fit(self, is_latched: bool, size: int) -> bool:
        """Change the quality of service to that of the next message.

        :param is_latched: whether the message is latched
        :param size: its size [bytes]
        :returns: whether the publisher is a new one, which subscribers have yet to discover
        """
        if is_latched == self.is_latched and size <= self._size:
            return False
        # In powers of two: each change interrupts the topic.
        self._size = max(self._size, 1 << (size - 1).bit_length() if size else 0)
        quality = self._quality_of(is_latched, self._size)
        if quality == self._quality and is_latched == self.is_latched:
            return False
        self.is_latched, self._quality, self._latest = is_latched, quality, b""
        self._remake(self.owner)
        return True

    def publish(self, data: bytes) -> None:
        """Publish a message."""
        self._latest = data if self.is_latched else b""
        self._publisher.publish(data)

    def held_at_most(self) -> int:
        """Return the upper bound of bytes that it holds for subscribers that do not read."""
        return self._quality.depth * self._size

    def move(self, owner: Ros2Node) -> None:
        """Move the publisher to another node, if the node differs."""
        if owner is not self.owner:
            self._remake(owner)
            if self._latest:
                self._publisher.publish(self._latest)

    def _remake(self, owner: Ros2Node) -> None:
        before, self.owner = (self.owner, self._publisher), owner
        self._publisher = self._make(owner, self._quality)
        self._participant.destroy_publisher(*before)

    def close(self) -> None:
        """Close the publisher, and withdraw its latched message."""
        self._participant.destroy_publisher(self.owner, self._publisher)


class TopicPublishers:
    """Publishers of a topic in ROS 2, one per ROS 1 node.

    A new publisher may send its first message before subscribers have discovered it. If both are
    reliable, DDS resends it. But a volatile subscriber does not get an older latched message; so
    a latched message is sent only after the discovery time.

    :param participant: the bridge in ROS 2
    :param make: creates a publisher of a node with a quality of service
    :param quality: returns the quality, latched or not, for messages of a size [bytes]
    """

    def __init__(self, participant: Participant, make: MakePublisher, quality: QualityOf) -> None:
        self._participant, self._make, self._quality_of = participant, make, quality
        self._lock = threading.Lock()
        self._by_caller: BridgedResources[str, NodePublisher] = BridgedResources()
        self._is_closed = False

    def update_publishers(
        self, callers: Set[str], owners: Mapping[str, Ros2Node], is_heard: bool
    ) -> None:
        """Adapt the publishers to those in ROS 1.

        :param callers: names of the nodes that publish it in ROS 1
        :param owners: the ROS 1 nodes that are shown in ROS 2
        :param is_heard: whether it has subscribers in ROS 2
        """
        if not callers:
            return  # the master was restarted
        with self._lock:
            self._by_caller.close_missing(
                callers if owners.keys() >= callers else {*callers, _OTHERS}
            )
            for caller in sorted(callers):
                owner = owners.get(caller, self._participant.node)
                mine = self._by_caller.get(caller)
                if mine is not None:
                    # Subscribers would receive a latched message twice.
                    if not (mine.is_latched and is_heard and mine.owner is self._participant.node):
                        mine.move(owner)
                elif caller in owners:
                    self._add(caller, owner)
                elif _OTHERS not in self._by_caller:
                    self._add(_OTHERS, owner)

    def _add(self, caller: str, owner: Ros2Node) -> NodePublisher:
        made = self._by_caller[caller] = NodePublisher(
            self._participant, self._make, self._quality_of, owner
        )
        return made

    def publish(self, caller: str, data: bytes, is_latched: bool) -> None:
        """Publish a message.

        :param caller: name of the publishing ROS 1 node
        :param is_latched: whether late subscribers receive it, too
        """
        with self._lock:
            if self._is_closed:
                return
            mine = self._by_caller.get(caller)
            if mine is None and not is_latched:  # the node is not shown in ROS 2, or not yet
                mine = self._plain() or self._add(_OTHERS, self._participant.node)
            elif mine is None:
                mine = self._add(caller, self._participant.node)
            is_unknown = mine.fit(is_latched, len(data))
            if not is_unknown:
                mine.publish(data)
        if is_unknown:
            time.sleep(_KNOWN_S)
            with self._lock:
                if mine in self._by_caller.values():
                    mine.publish(data)

    def has_latched(self) -> bool:
        """Return whether any of them has a latched message."""
        with self._lock:
            return any(one.is_latched for one in self._by_caller.values())

    def held_at_most(self) -> int:
        """Return the upper bound of bytes held for subscribers that do not read."""
        with self._lock:
            return sum(one.held_at_most() for one in self._by_caller.values())

    def _plain(self) -> Optional[NodePublisher]:
        """Return a publisher without a latched message."""
        return next((one for one in self._by_caller.values() if not one.is_latched), None)

    def close(self) -> None:
        """Close all publishers."""
        with self._lock:
            self._is_closed = True
            for caller in list(self._by_caller):
                self._by_caller.close_one(caller)
