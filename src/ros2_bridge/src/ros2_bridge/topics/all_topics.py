"""Topic bridge: discovers topics, and bridges each as long as it exists."""

import contextlib
from typing import Dict, List, Optional, Set, Union

from rclpy.node import Node as Ros2Node
from rclpy.validate_full_topic_name import validate_full_topic_name

from nodekit import Node
from ros2_bridge.actions.discovery import is_of_action
from ros2_bridge.health.topic_health import TopicCounts
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.graph import Topic
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.ros2.peer_definitions import PeerDefinitions
from ros2_bridge.rules.selection import RESERVED_PACKAGES, Rules, Route, select_routes
from ros2_bridge.rules.active_pairs import PairBridge, for_all
from ros2_bridge.rules.settings import QosProfiles
from ros2_bridge.rules.skip_log import SkipLog, Unbridgeable
from ros2_bridge.topics.one_topic import TopicToRos1, TopicToRos2
from ros2_bridge.types.type_registry import MessageType, TypeRegistry

_Pair = Union[TopicToRos1, TopicToRos2]


class TopicBridge(PairBridge[_Pair]):
    """Pairs of topics, created and closed as topics appear and disappear.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        types: TypeRegistry,
        qualities: QosProfiles,
        skip_log: SkipLog,
    ) -> None:
        super().__init__(skip_log)
        self._definitions = PeerDefinitions(participant)
        self._node, self._participant, self._types, self._qualities = (
            node,
            participant,
            types,
            qualities,
        )

    def update_topics(
        self,
        rules: Rules,
        ros1: Ros1Graph,
        ros2: Dict[str, Topic],
        owners: Dict[str, Ros2Node],
    ) -> None:
        """Create and close pairs after a poll of both graphs.

        :param ros2: the ROS 2 topics, by ROS 1 name
        :param owners: the ROS 1 nodes that are shown in ROS 2
        """
        self._rules, self._ros1, self._ros2, self._owners = rules, ros1, ros2, owners
        of_actions = {name for name, kind in ros1.types.items() if is_of_action(name, kind)}
        published1 = set(ros1.publishers) - of_actions
        published2 = {name for name, topic in ros2.items() if topic.publishers}
        try:
            self.update_pairs(select_routes(rules, published1, published2))
        finally:
            for_all(self.pairs, self._follow)

    def _follow(self, route: Route) -> None:
        pair = self.pairs[route]
        pair.limit.set_rate(self._rules.max_rates.of(route.name))
        if isinstance(pair, TopicToRos2):
            self._update_publishers(pair)
            pair.forward_while(self._is_heard(route.name))
            return
        if route.name in self._ros2:
            pair.follow_publishers(self._ros2[route.name])
        pair.forward_if_heard()

    def follow_subscribers1(self) -> None:
        """Subscribe in ROS 2 while there are ROS 1 subscribers, which needs no request to rospy."""
        pairs = (pair for pair in self.pairs.values() if isinstance(pair, TopicToRos1))
        for_all(pairs, TopicToRos1.forward_if_heard)

    def _has_same_type(self, route: Route, pair: _Pair) -> bool:
        if isinstance(pair, TopicToRos2):
            return self._type1(route) in (None, pair.kind.ros1)
        types = self._types2(route)
        return not types or pair.kind.ros1 in map(self._types.ros1_name, types)

    def _has_known_definitions(self, route: Route) -> bool:
        """Return whether the endpoint in ROS 2 uses the bridge's definition of the type.

        :returns: False if it is not known yet
        :raises Unbridgeable: if the definitions differ
        """
        found = self._ros2[route.name].definitions if route.name in self._ros2 else set()
        return all(
            self._definitions.are_known_to_fit(route.name, type_name, type_hash, node)
            for publishes, type_name, type_hash, node in sorted(found)
            if publishes != route.to_ros2
        )

    def _is_as_begun(self, route: Route, pair: _Pair) -> bool:
        found = self._ros2.get(route.name)
        try:
            if not self._has_known_definitions(route):
                return False
        except Unbridgeable:
            return False  # creating it again reports the reason
        return found is None or isinstance(pair, TopicToRos2) or pair.fits(found)

    def _begin(self, route: Route) -> Optional[_Pair]:
        kind = self._kind(route)
        if kind is None or not self._has_known_definitions(route):
            return None
        name, other = route.name, self._rules.names.in_ros2(route.name) or route.name
        validate_full_topic_name(other)  # /robot/1 is legal in ROS 1 only
        node, participant, qualities = self._node, self._participant, self._qualities
        if route.to_ros2:
            pair = TopicToRos2(node, participant, name, other, kind, qualities)
            self._update_publishers(pair)
            return pair
        return TopicToRos1(node, participant, name, other, kind, qualities, self._ros2[name])

    def _update_publishers(self, pair: TopicToRos2) -> None:
        callers = self._ros1.publishers.get(pair.topic, set())
        pair.publishers.update_publishers(callers, self._owners, self._is_heard(pair.topic))
        pair.forget_all_but(callers)

    def _is_heard(self, name: str) -> bool:
        """Return whether a topic has subscribers in ROS 2."""
        return name in self._ros2 and bool(self._ros2[name].subscribers)

    def _type1(self, route: Route) -> Optional[str]:
        """Return the type of a topic in ROS 1; None if no publisher announces it."""
        found = self._ros1.types.get(route.name)
        return None if found == "*" else found

    def _types2(self, route: Route) -> Set[str]:
        """Return the types of a topic in ROS 2."""
        return self._ros2[route.name].types if route.name in self._ros2 else set()

    def _kind(self, route: Route) -> Optional[MessageType]:
        """Return the type of a topic; None if it is not known yet, or differs between the ROSes.

        :raises Unbridgeable: if there is no common type
        """
        type1, types2 = self._type1(route), self._types2(route)
        if route.to_ros2 and type1 is None:
            return None
        if any(name.startswith(RESERVED_PACKAGES) for name in (type1 or "", *types2)):
            return None
        names = {self._types.ros1_name(name) for name in types2}
        used: List[str] = sorted(types2)
        if type1 is not None:
            names.add(type1)
            used.insert(0, f"{type1} in ROS 1")
        if len(names) > 1:
            here, there = ("ROS 2", "ROS 1") if route.to_ros2 else ("ROS 1", "ROS 2")
            other = self.pairs.get(Route(route.name, not route.to_ros2))
            kept = f" (to {there} it is bridged as {other.kind.ros1})" if other else ""
            raise Unbridgeable(
                f"{route.name} to {here}, as it has several types: {', '.join(used)}{kept}"
            )
        return self._types.message(names.pop())

    def types(self) -> Dict[Route, str]:
        """Return the ROS 1 type name of each pair, including topics without messages so far."""
        found = {route: pair.kind.ros1 for route, pair in self.pairs.items()}
        subscribed = {name for name, topic in self._ros2.items() if topic.subscribers}
        for route in select_routes(self._rules, subscribed, set()):
            with contextlib.suppress(Unbridgeable):
                kind = self._types.message(self._types.ros1_name(min(self._ros2[route.name].types)))
                found.setdefault(route, kind.ros1)
        return found

    def counts(self) -> Dict[Route, TopicCounts]:
        """Return the current counters of each pair."""
        return {route: pair.counts() for route, pair in list(self.pairs.items())}
