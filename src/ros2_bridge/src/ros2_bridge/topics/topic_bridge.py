"""All topics: finds those that others publish, and bridges them until they go."""

from typing import Dict, List, Optional, Union

from rclpy.validate_full_topic_name import validate_full_topic_name

from nodekit import Node
from ros2_bridge.ros1.ros1_graph import Ros1Graph
from ros2_bridge.ros1.telling import Telling
from ros2_bridge.ros2.ros2_graph import Topic
from ros2_bridge.ros2.ros2_side import Ros2
from ros2_bridge.rules.pairing import OWN_WAYS, Patience, Rules, Way, wanted
from ros2_bridge.rules.settings import Qualities
from ros2_bridge.topics.topics import Count, ToRos1, ToRos2
from ros2_bridge.types.types import MessageType, Types, Unbridgeable

#: How many looks a topic may be missing until it is bridged no longer.
LOOKS = 4


class TopicBridge:
    """Keeps the pairs of topics as both graphs want them.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    """

    def __init__(
        self, node: Node, side: Ros2, types: Types, qualities: Qualities, telling: Telling
    ) -> None:
        self._node, self._side, self._types = node, side, types
        self._qualities, self._telling = qualities, telling
        self.pairs: Dict[Way, Union[ToRos1, ToRos2]] = {}
        self._patience: Patience[Way] = Patience(LOOKS)

    def look(self, rules: Rules, ros1: Ros1Graph, ros2: Dict[str, Topic]) -> None:
        """Begin and end what this look at both graphs asks for."""
        published2 = {name for name, topic in ros2.items() if topic.publishers}
        ways = wanted(rules, set(ros1.publishers), published2)
        for way in self._patience.gone(self.pairs, ways):
            self.pairs.pop(way).close()
        for way in ways:
            found = ros2.get(way.name)
            pair = self.pairs.get(way)
            type1 = ros1.types.get(way.name)
            if pair is not None and not self._has_type(pair, type1, found):
                self.pairs.pop(way).close()
                continue  # of the new type at the next look: ROS 2 has the old one until then
            if isinstance(pair, ToRos1) and found is not None and not pair.is_still(found):
                self.pairs.pop(way).close()
                pair = None
            if pair is None:
                with self._telling.guarding(way.name):
                    self._begin(way, rules, type1, found)
        for way, pair in self.pairs.items():
            if isinstance(pair, ToRos2):
                found = ros2.get(way.name)
                listeners = found is not None and bool(found.subscribers)
                pair.look(listeners, ros1.publishers.get(way.name, set()))
        self.listen()

    def listen(self) -> None:
        """Hear what somebody in ROS 1 has begun to listen to: rospy tells without a request."""
        for pair in self.pairs.values():
            if isinstance(pair, ToRos1):
                pair.look()

    def _has_type(
        self, pair: Union[ToRos1, ToRos2], type1: Optional[str], found: Optional[Topic]
    ) -> bool:
        """Tell whether a topic is still published with the type of its pair."""
        if isinstance(pair, ToRos2):
            return type1 in (None, "*", pair.kind.ros1)
        types = found.types if found is not None else set()
        return not types or pair.kind.ros1 in map(self._types.ros1_name, types)

    def _begin(self, way: Way, rules: Rules, type1: Optional[str], found: Optional[Topic]) -> None:
        try:
            kind = self._kind(way, type1, found)
        except Unbridgeable as reason:
            self._telling.say(str(reason))
            return
        if kind is None:
            return
        names = (way.name, rules.names.in_ros2(way.name) or way.name)
        validate_full_topic_name(names[1])  # /robot/1 is one in ROS 1, and none in ROS 2
        if way.to_ros2:
            self.pairs[way] = ToRos2(self._node, self._side, *names, kind, self._qualities)
        elif found is not None:
            self.pairs[way] = ToRos1(self._node, self._side, *names, kind, self._qualities, found)

    def _kind(
        self, way: Way, type1: Optional[str], found: Optional[Topic]
    ) -> Optional[MessageType]:
        """Return the type of a topic, None where nobody tells it, or each ROS has it for itself.

        :raises Unbridgeable: if it is not one for both sides
        """
        known = None if type1 in (None, "*") else str(type1)
        if way.to_ros2 and known is None:
            return None
        types = found.types if found is not None else set()
        if any(name.startswith(OWN_WAYS) for name in (known or "", *types)):
            return None
        names: List[str] = sorted({self._types.ros1_name(name) for name in types})
        if len({*names, *([known] if known else [])}) > 1:
            used = ", ".join([*([f"{known} in ROS 1"] if known else []), *sorted(types)])
            raise Unbridgeable(f"{way.name}, which is used with several types: {used}")
        return self._types.message(known or names[0])

    def counts(self) -> Dict[Way, Count]:
        """Return how much has gone through each pair."""
        return {way: pair.count for way, pair in list(self.pairs.items())}
