"""Looks at both graphs, again and again, and has each part of the bridge follow them."""

import threading
import traceback
from typing import Any, Dict, Set

import rospy

from nodekit import LiveParameters, MasterUnreachable, Node
from nodekit.master import MasterClient
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.kinds import MISSING
from ros2_bridge.node_bridge import NodeBridge
from ros2_bridge.ros1 import ros1_graph
from ros2_bridge.ros1.names_in_ros1 import NamesInRos1
from ros2_bridge.ros1.telling import Telling
from ros2_bridge.ros2.ros2_graph import Ros2Graph
from ros2_bridge.ros2.ros2_side import Ros2
from ros2_bridge.rules.pairing import ROSOUT, is_never_bridged
from ros2_bridge.rules.settings import BridgeParameters, Qualities
from ros2_bridge.services.service_bridge import ServiceBridge
from ros2_bridge.topics.rosout import Rosout
from ros2_bridge.topics.topic_bridge import TopicBridge
from ros2_bridge.types.types import Types

#: Pause between two turns, s, and how many of them there are to a look.
_TURN_S, _TURNS = 0.1, 5
#: How many looks come one each turn at first: what there is in ROS 2 is heard of bit by bit.
_FIRST = 10
#: Longest wait for the master, s.
_MASTER_S = 2.0


class Looking:
    """All parts of the bridge, and the thread that has them follow the graphs.

    :param node: the bridge in ROS 1
    :param parameters: the bridge's
    :raises ParameterError: if the qualities of service make no sense
    """

    def __init__(self, node: Node, parameters: "LiveParameters[BridgeParameters]") -> None:
        self._node, self._parameters = node, parameters
        self._master = get_watcher().client
        # Of its own: it remembers the latest answers.
        self._asking = MasterClient(node.name, timeout=_MASTER_S)
        qos = self._master.read([node.resolve("~qos")]).values[node.resolve("~qos")]
        qualities = Qualities(parameters.values.depth, None if qos is MISSING else qos)
        self._renaming = names = parameters.values.names()
        self._side = Ros2(names.in_ros2(node.name) or node.name)
        self._graph, self._telling, types = Ros2Graph(self._side, names), Telling(), Types()
        self._topics = TopicBridge(node, self._side, types, qualities, self._telling)
        self._nodes = NodeBridge(node, self._side, self._master, names, self._telling)
        self._services = ServiceBridge(
            *(node, self._side, self._asking, types, self._telling),
            lambda: parameters.values.service_timeout,
        )
        self._rosout, self._names = Rosout(node, self._side, names), NamesInRos1()
        self._master_pid = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="looks", daemon=True)
        self._thread.start()
        node.before_end(self.close)

    def _run(self) -> None:
        turn = 0
        while not self._ended.wait(_TURN_S if self._node.is_up else 0.01):
            if not self._node.is_up:
                continue
            turn += 1
            try:
                if turn <= _FIRST or turn % _TURNS == 0:
                    self._look()
                else:
                    self._topics.listen()
            except MasterUnreachable as error:  # all stays as it is until it is back
                rospy.logwarn_throttle(10.0, f"nothing new is bridged: {error}")
            except Exception:
                if not self._ended.is_set():
                    rospy.logerr_throttle(10.0, traceback.format_exc())

    def _look(self) -> None:
        ros1 = ros1_graph.look(self._asking, {self._node.name, *self._names.names})
        is_restarted = self._master_pid not in (0, ros1.master_pid)
        self._master_pid = ros1.master_pid
        values, in_ros2, topics = self._parameters.values, self._graph.nodes(), self._graph.topics()
        rules = values.openings(self._renaming)
        self._names.look(in_ros2 - ros1.nodes(), is_restarted)
        self._rosout.look(ROSOUT in topics and bool(topics[ROSOUT].subscribers))
        self._topics.look(rules, ros1, topics)
        services = self._graph.services(in_ros2)
        parameters, most = values.parameters, values.max_nodes
        self._nodes.look(ros1, in_ros2, services, parameters, most, is_restarted)
        self._services.look(rules, ros1, services, self._nodes.homes())
        self._tell_of_nameless({*ros1.publishers, *ros1.services, *ros1.nodes()})
        self._telling.look()

    def _tell_of_nameless(self, in_ros1: Set[str]) -> None:
        for name in in_ros1:
            if self._renaming.in_ros2(name) is None and not is_never_bridged(name):
                self._telling.say(f"{name} of ROS 1, as its name in ROS 2 is another's")
        for name in self._graph.nameless:
            self._telling.say(f"{name} of ROS 2, as its name in ROS 1 is another's")
        self._graph.nameless.clear()

    def statistics(self) -> Dict[str, Any]:
        """Return what has gone through each pair of topics, and what was lost."""
        topics: Dict[str, Any] = {"to_ros1": {}, "to_ros2": {}}
        for way, count in self._topics.counts().items():
            topics["to_ros2" if way.to_ros2 else "to_ros1"][way.name] = vars(count)
        return {"topics": topics}

    def close(self) -> None:
        """End ROS 2's side, all at once, while ROS 1's is there; rospy then ends that."""
        self._ended.set()
        self._thread.join(0.5)
        self._names.close()
        self._side.close()
