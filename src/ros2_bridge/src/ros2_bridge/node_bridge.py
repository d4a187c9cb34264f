"""Node bridge: shows the nodes of each ROS in the other, with their parameters."""

import re
import time
from typing import Callable, Collection, Dict, List, Optional, Set

from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node as Ros2Node
from rclpy.serialization import deserialize_message

from nodekit import Node, NodeScope
from nodekit.master import MasterClient
from ros2_bridge.parameters.ros1_parameters import (
    DescribedParameters,
    Ros1Parameters,
    ServerParameters,
)
from ros2_bridge.parameters.ros1_mirror import ParametersToRos1
from ros2_bridge.parameters.parameter_services import ParametersToRos2
from ros2_bridge.ros1.graph import Ros1Graph
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.ros2.received_message import ReceivedMessage
from ros2_bridge.rules.selection import parameter_services, rank_names
from ros2_bridge.rules.active_pairs import BridgedResources
from ros2_bridge.rules.renaming import Renaming
from ros2_bridge.rules.settings import QosProfile
from ros2_bridge.rules.skip_log import SkipLog

try:
    from ros2_bridge.parameters.reconfigured_parameters import (
        SERVICE as RECONFIGURE,
        ReconfiguredParameters,
    )

    AVAILABLE = True
except ImportError:  # dynamic_reconfigure is optional
    AVAILABLE = False

_EVENTS = "/parameter_events"
#: Time for a node to describe its parameters [s]. Afterwards it counts as a node without
#: descriptions, and every value is accepted; before, it may be starting, and reject some values.
_DESCRIBE_S = 5.0
_LEGAL = re.compile(r"(/[A-Za-z][A-Za-z0-9_]*)+\Z")


class NodeToRos2:
    """A ROS 1 node in ROS 2: its name, and its parameters.

    It persists, with its topics and services, while its parameters appear and disappear.

    :param participant: the bridge in ROS 2
    :param other: its global name in ROS 2
    :param destroy: called with it at the end

    :ivar node: the ROS 2 node
    :ivar style: how its parameters are bridged
    """

    def __init__(
        self, participant: Participant, other: str, destroy: Callable[[Ros2Node], None]
    ) -> None:
        self.node, self._destroy = participant.create_node(other), destroy
        self.style = "none"
        self._parameters: Optional[ParametersToRos2] = None

    def set_parameters(self, style: str, parameters: Optional[ParametersToRos2]) -> None:
        """Change how the parameters are bridged; None stops it."""
        if self._parameters is not None:
            self._parameters.close()
        self.style, self._parameters = style, parameters

    def close(self) -> None:
        """Close the node."""
        self.set_parameters("none", None)
        self._destroy(self.node)


class NodeBridge:
    """Node bridge: keeps the nodes up to date with both graphs; all names are ROS 1 names.

    :param node: the bridge in ROS 1
    :param participant: the bridge in ROS 2
    :param client: client of the master
    :param names: renaming rules
    :param skip_log: receives the nodes that are not bridged
    :param is_kind: returns whether an integer is accepted for a double
    """

    def __init__(
        self,
        node: Node,
        participant: Participant,
        client: MasterClient,
        names: Renaming,
        skip_log: SkipLog,
        is_kind: Callable[[], bool],
    ) -> None:
        self._node, self._participant, self._client, self._skip_log = (
            node,
            participant,
            client,
            skip_log,
        )
        self._names, self._is_kind = names, is_kind
        self._to_ros2: BridgedResources[str, NodeToRos2] = BridgedResources()
        self._to_ros1: BridgedResources[str, ParametersToRos1] = BridgedResources()
        self._own: Optional[ParametersToRos2] = None
        #: Closed nodes, until other nodes have taken their topics and services.
        self._leaving: List[Ros2Node] = []
        #: When each node was first seen, on the monotonic clock [s].
        self._since: Dict[str, float] = {}
        self._events = participant.create_publisher(
            participant.node, ParameterEvent, _EVENTS, QosProfile(1000)
        )
        participant.create_subscription(
            ParameterEvent, _EVENTS, QosProfile(1000), self._forward_events
        )

    def update_nodes(
        self,
        ros1: Ros1Graph,
        in_ros2: Set[str],
        services2: Collection[str],
        parameters: bool,
        most: int,
        is_restarted: bool,
    ) -> None:
        """Create and close nodes after a poll of both graphs.

        :param in_ros2: names of the ROS 2 nodes
        :param services2: names of their services
        :param parameters: whether parameters are bridged
        :param most: most ROS 1 nodes to show
        :param is_restarted: whether the master was restarted, and has lost its state
        """
        while self._leaving:
            self._participant.destroy_node(self._leaving.pop())
        services = set(ros1.services)
        describing = {name.rpartition("/")[0] for name in parameter_services(services)}
        wanted = self._chosen(ros1.nodes() - in_ros2, describing - in_ros2, most)
        now = time.monotonic()
        self._since = {name: self._since.get(name, now) for name in wanted}
        self._to_ros2.close_missing(wanted)
        for name in wanted:
            style = "plain" if now > self._since[name] + _DESCRIBE_S else "none"
            if AVAILABLE and f"{name}/{RECONFIGURE}" in services:
                style = "reconfigured"
            style = "described" if name in describing else style
            style = style if parameters else "none"
            with self._skip_log.catching(name):  # ROS 2 may reject the name
                self._update_to_ros2(name, style)
        listing = {name for name in in_ros2 if f"{name}/list_parameters" in services2}
        self._update_to_ros1(listing - ros1.nodes() if parameters else set(), most, is_restarted)

    def _update_to_ros2(self, name: str, style: str) -> None:
        if name not in self._to_ros2:
            self._to_ros2[name] = NodeToRos2(
                self._participant, self._other(name), self._leaving.append
            )
        if self._to_ros2[name].style != style:  # a managed node has parameters only at times
            self._to_ros2[name].set_parameters("none", None)
            self._to_ros2[name].set_parameters(style, self._parameters(name, style))

    def _other(self, name: str) -> str:
        """Return the ROS 2 name for a ROS 1 name."""
        return self._names.in_ros2(name) or name

    def _chosen(self, nodes: Set[str], describing: Set[str], most: int) -> List[str]:
        """Return the nodes to show: registered ones first, then hosted ones with ~describe."""
        order = rank_names(self._to_ros2, nodes, describing)
        legal = [name for name in order if _LEGAL.match(self._names.in_ros2(name) or "")]
        return self._at_most(legal, most, "nodes of ROS 1")

    def _at_most(self, names: List[str], most: int, what: str) -> List[str]:
        """Return the first ``most`` names, and report the others."""
        left = len(names) - most
        if left > 0:
            some = ", ".join(names[most : most + 3]) + (f" and {left - 3} more" if left > 3 else "")
            self._skip_log.report(f"{what} beyond ~max_nodes, {most}: {some}")
        return names[:most]

    def offer_own_parameters(self) -> None:
        """Offer the bridge's own parameters in ROS 2, unless already offered."""
        if self._own is None:
            name = self._node.name
            self._own = self._bridged(
                self._participant.node,
                DescribedParameters(self._client, name),
                self._node.create_scope(),
            )

    def _parameters(self, name: str, style: str) -> Optional[ParametersToRos2]:
        """Bridge the parameters of a ROS 1 node.

        :param style: "described" if the node describes them, "reconfigured" if dynamic_reconfigure
            does, else "plain"
        """
        if style == "none":
            return None
        scope, node = self._node.create_scope(), self._to_ros2[name].node
        if style == "reconfigured":
            return self._bridged(node, ReconfiguredParameters(self._client, name, scope), scope)
        kind = DescribedParameters if style == "described" else ServerParameters
        return self._bridged(node, kind(self._client, name), scope)

    def _bridged(
        self, node: Ros2Node, parameters: Ros1Parameters, scope: NodeScope
    ) -> ParametersToRos2:
        return ParametersToRos2(
            scope,
            self._participant,
            node,
            self._other(parameters.name),
            parameters,
            self._events.publish,
            self._is_kind,
        )

    def _update_to_ros1(self, nodes: Set[str], most: int, is_restarted: bool) -> None:
        order = rank_names(self._to_ros1, nodes)
        wanted = self._at_most(order, most, "parameters of nodes of ROS 2")
        self._to_ros1.close_missing(wanted)
        for name in wanted:
            if name not in self._to_ros1:
                with self._skip_log.catching(name):
                    self._to_ros1[name] = ParametersToRos1(
                        self._participant, self._client, name, self._other(name), self._skip_log
                    )
                continue
            self._to_ros1[name].report_unfit()
            if is_restarted:
                self._to_ros1[name].write_all()
            else:
                self._to_ros1[name].retry_write_all()

    def _forward_events(self, arrived: List[ReceivedMessage]) -> None:
        for one in arrived:
            if not self._participant.is_own(one.sender):
                event = deserialize_message(one.data, ParameterEvent)
                parameters = self._to_ros1.get(self._names.in_ros1(event.node) or "")
                if parameters is not None:
                    parameters.write_event(event)

    def in_ros2(self) -> Dict[str, Ros2Node]:
        """Return the ROS 2 nodes that represent ROS 1 nodes, by name."""
        return {name: shown.node for name, shown in self._to_ros2.items()}
