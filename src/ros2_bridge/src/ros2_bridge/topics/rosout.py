"""Log bridge, ROS 1 to ROS 2 only: publishes log lines of ROS 1 nodes on /rosout of ROS 2."""

from typing import Any, Callable, Mapping, NamedTuple

from rcl_interfaces.msg import Log
from rclpy.node import Node as Ros2Node

from nodekit import Node, ReentrantCallbackGroup
from ros2_bridge.environment.ros1_messages import Log as Ros1Log
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.selection import ROSOUT
from ros2_bridge.rules.active_pairs import BridgedResources
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.topics.one_topic import OnDemandSubscription

#: ROS 2 log levels by ROS 1 level.
_LEVELS = {1: Log.DEBUG, 2: Log.INFO, 4: Log.WARN, 8: Log.ERROR, 16: Log.FATAL}


class NodeLog(NamedTuple):
    """Publisher of the log lines of one node.

    :param participant: the bridge in ROS 2
    :param owner: the publishing ROS 2 node
    """

    participant: Participant
    owner: Ros2Node
    publisher: Any

    def close(self) -> None:
        """Close the publisher."""
        self.participant.destroy_publisher(self.owner, self.publisher)


class Rosout:
    """Bridge of log lines; each is published by its own node in ROS 2.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param names: renaming rules

    :ivar subscription: to ROS 1's log; enabled while ROS 2's has subscribers
    """

    def __init__(self, node: Node, participant: Participant, names: Renaming) -> None:
        self._node, self._participant, self._names = node, participant, names
        self._logs: BridgedResources[str, NodeLog] = BridgedResources(1)
        self._of_others = self._create_log(participant.node)
        self.subscription = OnDemandSubscription(self._subscribe)

    def _create_log(self, owner: Ros2Node) -> NodeLog:
        quality = QosProfile(1000, latched=True)
        return NodeLog(
            self._participant,
            owner,
            self._participant.create_publisher(owner, Log, ROSOUT, quality),
        )

    def update_nodes(self, owners: Mapping[str, Ros2Node]) -> None:
        """Adapt the log publishers to the nodes in ROS 2.

        :param owners: the ROS 2 nodes that represent ROS 1 nodes, by name
        """
        self._logs.close_missing(
            {name for name, log in self._logs.items() if owners.get(name) is log.owner}
        )
        for name, owner in owners.items():
            if name not in self._logs:
                self._logs[name] = self._create_log(owner)

    def _subscribe(self) -> Callable[[], None]:
        scope = self._node.create_scope()
        scope.create_subscription(ROSOUT, Ros1Log, self._forward, group=ReentrantCallbackGroup())
        return scope.close

    def _forward(self, line: Any) -> None:
        log = Log(
            level=_LEVELS.get(line.level, Log.INFO),
            # Logger names in ROS 2 use dots.
            name=(self._names.in_ros2(line.name) or line.name).strip("/").replace("/", "."),
            msg=line.msg,
            file=line.file,
            function=line.function,
            line=line.line,
        )
        log.stamp.sec, log.stamp.nanosec = line.header.stamp.secs, line.header.stamp.nsecs
        self._logs.get(line.name, self._of_others).publisher.publish(log)
