"""Action bridge: discovers action servers, and bridges each as long as it exists."""

from typing import Dict, Optional, Tuple, Union

from rclpy.node import Node as Ros2Node
from rclpy.validate_full_topic_name import validate_full_topic_name

from ros2_bridge.action_bridge.ros2_server_in_ros1 import Ros2ServerInRos1
from ros2_bridge.action_bridge.ros1_server_in_ros2 import Ros1ServerInRos2
from ros2_bridge.actions.discovery import Server, servers_in_ros1, servers_in_ros2
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.call_bridge import CallBridge
from ros2_bridge.rules.selection import Rules, Route, select_routes

_Pair = Union[Ros2ServerInRos1, Ros1ServerInRos2]


class ActionBridge(CallBridge[_Pair]):
    """Pairs of actions, created and closed as servers appear and disappear."""

    def update_actions(
        self,
        rules: Rules,
        ros1: Ros1Graph,
        services2: Dict[str, Tuple[str, str]],
        owners: Dict[str, Ros2Node],
    ) -> None:
        """Create and close pairs after a poll of both graphs.

        :param services2: type and node of each ROS 2 service
        :param owners: the ROS 1 nodes that are shown in ROS 2
        """
        self._names, self._owners = rules.names, owners
        self._ros1 = servers_in_ros1(ros1.publishers, ros1.subscribers, ros1.types)
        self._ros2: Dict[str, Server] = {}
        for name, server in servers_in_ros2(services2).items():
            self._ros2[rules.names.in_ros1(name) or ""] = server
        in_ros1, in_ros2 = set(self._ros1), set(self._ros2) - {""}
        # A name with servers in both ROSes is not bridged.
        for name in sorted(filter(rules.allows, in_ros1 & in_ros2)):
            self._skip_log.report(
                f"{name}: both ROSes list a server of this action; if one was killed, ROS 2 drops"
                " it within 20 s, and ROS 1 after `rosnode cleanup`"
            )
        self.update_pairs(select_routes(rules, in_ros1 - in_ros2, in_ros2 - in_ros1))
        self.follow()

    def follow(self) -> None:
        """Update each pair from its server's state."""
        for route, pair in list(self.pairs.items()):
            with self._skip_log.catching(route.name):
                pair.follow()

    def end_goals(self) -> None:
        """Abort the goals of all clients on the other side."""
        for pair in list(self.pairs.values()):
            pair.end_goals()

    def _has_same_type(self, route: Route, pair: _Pair) -> bool:
        return self._type(route) == pair.kind.ros1

    def _is_as_begun(self, route: Route, pair: _Pair) -> bool:
        return isinstance(pair, Ros2ServerInRos1) or pair.owner is self._owner(route)

    def _begin(self, route: Route) -> Optional[_Pair]:
        name, other = route.name, self._names.in_ros2(route.name) or route.name
        validate_full_topic_name(f"{other}/_action/cancel_goal")  # the longest of its names
        kind = self._types.action(self._type(route))
        if route.to_ros2:
            owner = self._owner(route)
            return Ros1ServerInRos2(
                self._node, self._participant, owner, name, other, kind, self._timeout
            )
        return Ros2ServerInRos1(self._node, self._participant, name, other, kind, self._timeout)

    def _owner(self, route: Route) -> Ros2Node:
        """Return the node that offers a ROS 1 action in ROS 2."""
        return self._owner_of(self._ros1[route.name].node)

    def _type(self, route: Route) -> str:
        """Return the ROS 1 name of an action's type."""
        if route.to_ros2:
            return self._ros1[route.name].kind
        return self._types.ros1_name(self._ros2[route.name].kind)
