"""Base class of the service bridge and the action bridge: common state and answer timeout."""

from typing import Callable, Mapping, TypeVar

from rclpy.node import Node as Ros2Node

from nodekit import Node
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.active_pairs import Closable, PairBridge
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.types.type_registry import TypeRegistry

Pair = TypeVar("Pair", bound=Closable)


class CallBridge(PairBridge[Pair]):
    """Base class of a bridge of services or actions.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param types: types that exist in both ROSes
    :param skip_log: receives the reasons for missing pairs
    :param timeout: returns the timeout for a server's answer [s]
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        types: TypeRegistry,
        skip_log: SkipLog,
        timeout: Callable[[], float],
    ) -> None:
        super().__init__(skip_log)
        self._node, self._participant = node, participant
        self._types, self._timeout = types, timeout
        #: The ROS 1 nodes that are shown in ROS 2.
        self._owners: Mapping[str, Ros2Node] = {}

    def _owner_of(self, name: str) -> Ros2Node:
        """Return the ROS 2 node that offers the services of a ROS 1 node."""
        return self._owners.get(name, self._participant.node)
