"""All services: finds those that others offer, and bridges them until they go."""

from typing import Callable, Dict, Optional, Set, Tuple, Union

from rclpy.node import Node as Ros2Node
from rclpy.validate_full_topic_name import validate_full_topic_name

from nodekit import Node
from nodekit.master import MasterClient
from ros2_bridge.ros1.ros1_graph import Ros1Graph
from ros2_bridge.ros1.telling import Telling
from ros2_bridge.ros2.ros2_side import Ros2
from ros2_bridge.rules.pairing import OWN_WAYS, Patience, Rules, Way, wanted
from ros2_bridge.services.services import ServiceToRos1, ServiceToRos2
from ros2_bridge.topics.topic_bridge import LOOKS
from ros2_bridge.types.service_types import ServiceTypes
from ros2_bridge.types.types import Types, Unbridgeable


class ServiceBridge:
    """Keeps the pairs of services as both graphs want them.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param client: asks the master
    :param timeout: returns the longest wait for an answer, s
    """

    def __init__(
        self,
        node: Node,
        side: Ros2,
        client: MasterClient,
        types: Types,
        telling: Telling,
        timeout: Callable[[], float],
    ) -> None:
        self._node, self._side, self._types, self._telling = node, side, types, telling
        self._timeout = timeout
        self.pairs: Dict[Way, Union[ServiceToRos1, ServiceToRos2]] = {}
        self._patience: Patience[Way] = Patience(LOOKS)
        self._asked = ServiceTypes(client)

    def look(
        self,
        rules: Rules,
        ros1: Ros1Graph,
        ros2: Dict[str, Tuple[str, str]],
        homes: Dict[str, Ros2Node],
    ) -> None:
        """Begin and end what this look at both graphs asks for.

        :param ros2: type and node of each service of ROS 2, by its name in ROS 1
        :param homes: the nodes of ROS 1 that appear in ROS 2
        """
        in_ros1 = set(ros1.services) - described(set(ros1.services))
        in_ros2 = {name for name, (kind, _) in ros2.items() if not kind.startswith(OWN_WAYS)}
        self._asked.look(in_ros1)
        # A name that both sides have is not called for the other.
        ways = wanted(rules, in_ros1 - in_ros2, in_ros2 - in_ros1)
        for way in self._patience.gone(self.pairs, ways):
            self.pairs.pop(way).close()
        for way in ways:
            home = homes.get(ros1.services.get(way.name, ""), self._side.node)
            pair = self.pairs.get(way)
            if pair is not None and self._type(way, ros2) not in (None, pair.kind.ros1):
                self.pairs.pop(way).close()
                continue  # of the new type at the next look: it has taken leave until then
            if isinstance(pair, ServiceToRos2) and pair.home is not home:
                self.pairs.pop(way).close()  # its node appears in ROS 2 only now, or no longer
            if way not in self.pairs:
                with self._telling.guarding(way.name):
                    self._begin(way, rules, home, ros2)

    def _type(self, way: Way, ros2: Dict[str, Tuple[str, str]]) -> Optional[str]:
        """Return ROS 1's name of a service's type, None where its server has not told it yet."""
        if way.to_ros2:
            return self._asked.of(way.name)
        return self._types.ros1_name(ros2[way.name][0])

    def _begin(
        self, way: Way, rules: Rules, home: Ros2Node, ros2: Dict[str, Tuple[str, str]]
    ) -> None:
        names = (way.name, rules.names.in_ros2(way.name) or way.name)
        validate_full_topic_name(names[1], is_service=True)
        kind = self._type(way, ros2)
        if kind is None or kind.startswith(OWN_WAYS):
            return
        try:
            found = self._types.service(kind)
            if way.to_ros2:
                self.pairs[way] = ServiceToRos2(
                    self._node, self._side, home, *names, found, self._timeout
                )
            else:
                self.pairs[way] = ServiceToRos1(
                    self._node, self._side, *names, found, self._timeout
                )
        except Unbridgeable as reason:
            self._telling.say(str(reason))


def described(services: Set[str]) -> Set[str]:
    """Return those by which nodes made with nodekit tell and change their parameters.

    ROS 2 has its own for that.
    """
    spaces = {name.rpartition("/")[0] for name in services if name.endswith("/describe")}
    both = {space for space in spaces if f"{space}/change" in services}
    return {f"{space}/{name}" for space in both for name in ("describe", "change")}
