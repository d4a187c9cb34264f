"""ROS 2 publishers of a ROS 1 topic, one for each node that publishes it in ROS 1."""

import threading
import time
from typing import Any, Callable, Mapping, Optional, Set

from rclpy.node import Node as Ros2Node

from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.active_pairs import Bridged

#: How long it takes until all who subscribe know a new publisher [s].
_KNOWN_S = 0.1
#: Stands for all nodes that do not appear in ROS 2, as far as they do not latch.
_OTHERS = ""


class NodePublisher:
    """Publisher of a topic for one node of ROS 1, with its latest message if that is latched.

    Each has its own history, which no other node's messages fill.

    :param participant: the bridge in ROS 2
    :param make: makes a publisher of a node, latched or not
    :param owner: the node of ROS 2 that publishes it

    :ivar is_latched: whether those get the latest message, too, who come later
    """

    def __init__(
        self, participant: Participant, make: Callable[[Ros2Node, bool], Any], owner: Ros2Node
    ) -> None:
        self._participant, self._make, self.owner, self.is_latched = participant, make, owner, False
        self._publisher, self._latest = make(owner, False), b""

    def latch(self, is_latched: bool) -> bool:
        """Keep the latest message for those who come later, from the next one on, or no longer.

        :returns: whether it did otherwise before
        """
        if is_latched == self.is_latched:
            return False
        self.is_latched, self._latest = is_latched, b""
        self._remake(self.owner)
        return True

    def publish(self, data: bytes) -> None:
        """Publish a message."""
        self._latest = data if self.is_latched else b""
        self._publisher.publish(data)

    def move(self, owner: Ros2Node) -> None:
        """Have it published by another node, if that is another one."""
        if owner is not self.owner:
            self._remake(owner)
            if self._latest:
                self._publisher.publish(self._latest)

    def _remake(self, owner: Ros2Node) -> None:
        before, self.owner = (self.owner, self._publisher), owner
        self._publisher = self._make(owner, self.is_latched)
        self._participant.destroy_publisher(*before)

    def close(self) -> None:
        """Publish it no longer, and take back what is kept for those who come later."""
        self._participant.destroy_publisher(self.owner, self._publisher)


class TopicPublishers:
    """Publishes a topic in ROS 2, each message as of the node that it comes from.

    Who subscribes may not know a new publisher yet when that sends for the first time. Where both
    are reliable it is sent again then. But what is latched counts as sent before for a
    subscriber that asks for no earlier messages; so it is sent only when that is over.

    :param participant: the bridge in ROS 2
    :param make: makes a publisher of a node, latched or not
    """

    def __init__(self, participant: Participant, make: Callable[[Ros2Node, bool], Any]) -> None:
        self._participant, self._make = participant, make
        self._lock = threading.Lock()
        self._by_caller: Bridged[str, NodePublisher] = Bridged()
        self._is_closed = False

    def update_publishers(
        self, callers: Set[str], owners: Mapping[str, Ros2Node], is_heard: bool
    ) -> None:
        """Have those publish it who do so in ROS 1.

        :param callers: names of the nodes that publish it in ROS 1
        :param owners: the nodes of ROS 1 that appear in ROS 2
        :param is_heard: whether it has subscribers in ROS 2
        """
        if not callers:
            return  # the master has been restarted
        with self._lock:
            self._by_caller.close_missing(
                callers if owners.keys() >= callers else {*callers, _OTHERS}
            )
            for caller in sorted(callers):
                owner = owners.get(caller, self._participant.node)
                mine = self._by_caller.get(caller)
                if mine is not None:
                    # Of what is latched those who hear it would get the latest once more.
                    if not (mine.is_latched and is_heard and mine.owner is self._participant.node):
                        mine.move(owner)
                elif caller in owners:
                    self._add(caller, owner)
                elif _OTHERS not in self._by_caller:
                    self._add(_OTHERS, owner)

    def _add(self, caller: str, owner: Ros2Node) -> NodePublisher:
        made = self._by_caller[caller] = NodePublisher(self._participant, self._make, owner)
        return made

    def publish(self, caller: str, data: bytes, is_latched: bool) -> None:
        """Publish a message.

        :param caller: name of the node that it comes from
        :param is_latched: whether those get it, too, who come later
        """
        with self._lock:
            if self._is_closed:
                return
            mine = self._by_caller.get(caller)
            if mine is None and not is_latched:  # it does not appear in ROS 2, or not yet
                mine = self._plain() or self._add(_OTHERS, self._participant.node)
            elif mine is None:
                mine = self._add(caller, self._participant.node)
            is_unknown = mine.latch(is_latched) and is_latched
            if not is_unknown:
                mine.publish(data)
        if is_unknown:
            time.sleep(_KNOWN_S)
            with self._lock:
                if self._by_caller.get(caller) is mine:
                    mine.publish(data)

    def has_latched(self) -> bool:
        """Tell whether one of them keeps a message for those who come later."""
        with self._lock:
            return any(one.is_latched for one in self._by_caller.values())

    def _plain(self) -> Optional[NodePublisher]:
        """Return one of those that keep nothing for who comes later."""
        return next((one for one in self._by_caller.values() if not one.is_latched), None)

    def close(self) -> None:
        """Publish it no longer."""
        with self._lock:
            self._is_closed = True
            for caller in list(self._by_caller):
                self._by_caller.close_one(caller)
