"""The nodes of each ROS in the other, with their parameters."""

import re
import time
from typing import Any, Collection, Dict, List, Optional, Set, Union

from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node as Ros2Node
from rclpy.serialization import deserialize_message

from nodekit import Maker, Node
from nodekit.master import MasterClient
from ros2_bridge.parameters.parameter_sources import Described, Plain, WithSimTime
from ros2_bridge.parameters.parameters_to_ros1 import ParametersToRos1
from ros2_bridge.parameters.parameters_to_ros2 import ParametersToRos2
from ros2_bridge.ros1.ros1_graph import Ros1Graph
from ros2_bridge.ros1.telling import Telling
from ros2_bridge.ros2.ros2_side import Ros2
from ros2_bridge.rules.pairing import Patience, ranked
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import Quality
from ros2_bridge.services.service_bridge import described
from ros2_bridge.topics.topic_bridge import LOOKS

_EVENTS = "/parameter_events"
#: How long a node is given to describe its parameters, s, until it is taken for one that does not:
#: of those, everything is taken, even while one that would refuse it is still starting.
_DESCRIBE_S = 5.0
_LEGAL = re.compile(r"(/[A-Za-z][A-Za-z0-9_]*)+\Z")


class NodeTwin:
    """A node of ROS 1 in ROS 2: its name, and its parameters.

    It stays, with the services that it offers, while its parameters come and go.

    :ivar style: how its parameters are bridged
    :ivar made: what these have in ROS 1
    """

    def __init__(self, home: Ros2Node) -> None:
        self.home, self.style = home, "none"
        self.parameters: Optional[ParametersToRos2] = None
        self.made: Optional[Maker] = None

    def end_parameters(self) -> None:
        """Bridge the parameters no longer."""
        for part in (self.parameters, self.made):
            if part is not None:
                part.close()
        self.style, self.parameters, self.made = "none", None, None


class NodeBridge:
    """Keeps the nodes as both graphs have them; all of them are known by their names in ROS 1.

    :param node: the bridge in ROS 1
    :param side: the bridge in ROS 2
    :param client: asks the master
    :param names: what has another name in ROS 2
    """

    def __init__(
        self, node: Node, side: Ros2, client: MasterClient, names: Renaming, telling: Telling
    ) -> None:
        self._node, self._side, self._client, self._telling = node, side, client, telling
        self._names = names
        self.twins: Dict[str, NodeTwin] = {}
        self.mirrors: Dict[str, ParametersToRos1] = {}
        #: When each node was first seen, s on the monotonic clock.
        self._since: Dict[str, float] = {}
        self._patience: Patience[str] = Patience(LOOKS)
        self._mirror_patience: Patience[str] = Patience(LOOKS)
        self._tell = side.publisher(ParameterEvent, _EVENTS, Quality(1000))
        side.subscribe(ParameterEvent, _EVENTS, Quality(1000), self._hear)

    def look(
        self,
        ros1: Ros1Graph,
        in_ros2: Set[str],
        services2: Collection[str],
        parameters: bool,
        most: int,
        is_restarted: bool,
    ) -> None:
        """Begin and end what this look at both graphs asks for.

        :param in_ros2: names of the nodes of ROS 2
        :param services2: names of their services
        :param parameters: whether parameters are bridged
        :param most: how many nodes of ROS 1 may appear
        :param is_restarted: whether the master has forgotten everything
        """
        services = set(ros1.services)
        describing = {name.rpartition("/")[0] for name in described(services)}
        wanted = self._chosen(ros1.nodes() - in_ros2, describing - in_ros2, most)
        now = time.monotonic()
        self._since = {name: self._since.get(name, now) for name in wanted}
        for name in self._patience.gone(self.twins, wanted):
            self._end_twin(name)
        for name in wanted:
            style = "plain" if now > self._since[name] + _DESCRIBE_S else "none"
            style = "described" if name in describing else style
            style = style if parameters else "none"
            if name not in self.twins:
                home = self._side.make_node(self._names.in_ros2(name) or name)
                self.twins[name] = NodeTwin(home)
            if self.twins[name].style != style:  # a managed node has them only for a time
                self.twins[name].end_parameters()
                self._begin_parameters(name, style)
        telling = {name for name in in_ros2 if f"{name}/list_parameters" in services2}
        self._look_at_ros2(telling - ros1.nodes() if parameters else set(), most, is_restarted)

    def _chosen(self, nodes: Set[str], describing: Set[str], most: int) -> List[str]:
        """Return the nodes that appear: nodes before parts of nodes, which describe parameters."""
        order = ranked(self.twins, nodes, describing)
        legal = [name for name in order if _LEGAL.match(self._names.in_ros2(name) or "")]
        return self._at_most(legal, most, "nodes of ROS 1 as nodes of ROS 2")

    def _at_most(self, names: List[str], most: int, what: str) -> List[str]:
        """Return the first so many names, and say which are left out."""
        left = len(names) - most
        if left > 0:
            some = ", ".join(names[most : most + 3]) + (", …" if left > 3 else "")
            self._telling.say(f"{left} {what} (~max_nodes is {most}): {some}")
        return names[:most]

    def _begin_parameters(self, name: str, style: str) -> None:
        twin, other = self.twins[name], self._names.in_ros2(name) or name
        if style != "none":
            twin.made = self._node.lifetime()
            source: Union[Described, Plain] = Plain(self._client, name)
            if style == "described":
                source = Described(twin.made, name)
            whole, tell = WithSimTime(source, self._client), self._tell.publish
            twin.parameters = ParametersToRos2(
                self._node, self._side, twin.home, name, other, whole, tell
            )
        twin.style = style

    def _end_twin(self, name: str) -> None:
        twin = self.twins.pop(name)
        twin.end_parameters()
        self._side.destroy_node(twin.home)

    def _look_at_ros2(self, nodes: Set[str], most: int, is_restarted: bool) -> None:
        order = ranked(self.mirrors, nodes)
        wanted = self._at_most(order, most, "nodes of ROS 2 with their parameters")
        for name in self._mirror_patience.gone(self.mirrors, wanted):
            self.mirrors.pop(name).close()
        for name in wanted:
            if name not in self.mirrors:
                other = self._names.in_ros2(name) or name
                self.mirrors[name] = ParametersToRos1(
                    self._side, self._client, name, other, self._telling
                )
            elif is_restarted:
                self.mirrors[name].read()
            else:
                self.mirrors[name].look()

    def _hear(self, arrived: List[Any]) -> None:
        for data, info in arrived:
            if not self._side.is_ours(info["publisher_gid"]["data"]):
                event = deserialize_message(data, ParameterEvent)
                mirror = self.mirrors.get(self._names.in_ros1(event.node) or "")
                if mirror is not None:
                    mirror.take_event(event)

    def homes(self) -> Dict[str, Ros2Node]:
        """Return the nodes of ROS 2 that stand for nodes of ROS 1, by name."""
        return {name: twin.home for name, twin in self.twins.items()}
