"""The bridge: what is there in one ROS, is there in the other."""

import contextlib
import sys
import threading
import traceback
from typing import Any, Dict

import rospy
import yaml

from nodekit import CallError, MasterUnreachable, Node, run
from nodekit.life.server import Server
from nodekit.live.watcher import get_watcher
from nodekit.parameters.no_value import MISSING
from nodekit.process.ending import end
from nodekit.rospy_internals.shutdown import before_shutdown
from nodekit.transport.service_call import ServiceCall
from ros2_bridge import ros1_graph, rosout
from ros2_bridge.names_in_ros1 import NamesInRos1
from ros2_bridge.node_bridge import NodeBridge
from ros2_bridge.print_pairs import print_pairs
from ros2_bridge.ros1 import String, Trigger
from ros2_bridge.ros2_graph import Ros2Graph
from ros2_bridge.ros2_side import Ros2, domain
from ros2_bridge.rosout import Rosout
from ros2_bridge.service_bridge import ServiceBridge
from ros2_bridge.settings import BridgeParameters, Qualities
from ros2_bridge.telling import Telling
from ros2_bridge.topic_bridge import TopicBridge
from ros2_bridge.types import Types

#: Time between two looks at the graphs, s.
LOOK_S = 0.5


class Bridge:
    """Bridges topics, services, parameters and managed nodes between ROS 1 and ROS 2.

    :ROS Publishers:
        - ``~statistics`` (std_msgs/String): each second what has gone through, as YAML

    :ROS Parameters:
        - those of :class:`.BridgeParameters`, private and live; and ``~qos``, read at the start
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._parameters = node.parameters(BridgeParameters, exempt=("qos",))
        client = get_watcher().client
        qos = client.read([node.resolve("~qos")]).values[node.resolve("~qos")]
        depth = self._parameters.values.depth
        qualities = Qualities(depth, None if qos is MISSING else qos)
        self._side = Ros2(node.name)
        self._graph = Ros2Graph(self._side)
        self._telling = Telling()
        types = Types()
        self._topics = TopicBridge(node, self._side, types, qualities, self._telling)
        self._nodes = NodeBridge(node, self._side, client, self._telling)
        self._services = ServiceBridge(node, self._side, types, self._telling, self._timeout)
        self._rosout, self._names = Rosout(node, self._side), NamesInRos1()
        self._master_pid = 0
        node.service(marker(), Trigger, lambda _: (True, node.name))
        self._statistics = node.publisher("~statistics", String)
        node.every(1.0, self._publish_statistics, steady=True)
        self._ended = threading.Event()
        self._looking = threading.Thread(target=self._run, name="looks", daemon=True)
        self._looking.start()
        before_shutdown(self.close)

    def _run(self) -> None:
        while not self._ended.wait(LOOK_S if self._node.is_up else 0.01):
            if not self._node.is_up:
                continue
            try:
                self._look()
            except MasterUnreachable:
                continue  # all stays as it is until it is back
            except Exception:
                if not self._ended.is_set():
                    rospy.logerr_throttle(10.0, traceback.format_exc())

    def _look(self) -> None:
        own = {self._node.name, *self._names.names}
        ros1 = ros1_graph.look(get_watcher().client, own)
        values = self._parameters.values
        rules, in_ros2 = values.openings(), self._graph.nodes()
        is_restarted = self._master_pid not in (0, ros1.master_pid)
        self._master_pid = ros1.master_pid
        self._names.look(in_ros2 - ros1.nodes(), is_restarted)
        topics = self._graph.topics()
        self._rosout.look(rosout.TOPIC in topics and bool(topics[rosout.TOPIC].subscribers))
        self._topics.look(rules, ros1, topics)
        self._nodes.look(ros1, in_ros2, values.parameters, values.max_nodes, is_restarted)
        self._services.look(rules, ros1, self._graph.services(in_ros2), self._nodes.homes())
        self._telling.look()

    def _timeout(self) -> float:
        return self._parameters.values.service_timeout

    def _publish_statistics(self, _: float) -> None:
        if not self._statistics.get_num_connections():
            return
        topics: Dict[str, Any] = {"to_ros1": {}, "to_ros2": {}}
        for way, count in self._topics.counts().items():
            topics["to_ros2" if way.to_ros2 else "to_ros1"][way.name] = vars(count)
        self._statistics.publish(String(yaml.safe_dump({"topics": topics})))

    def close(self) -> None:
        """End it while both ROSes are there."""
        self._ended.set()
        self._looking.join(1.0)
        self._names.close()
        self._services.close()
        self._topics.close()
        self._nodes.close()
        self._side.close()


def marker() -> str:
    """Return the service that one bridge between this master and this domain offers."""
    return f"/ros2_bridge_of_domain_{domain()}"


def refuse_second() -> None:
    """End where there is such a bridge already: two would answer each other for ever."""
    with contextlib.suppress(CallError):
        call = ServiceCall(1.0)
        Server(marker(), Trigger).look(call)
        end(f"bridge: {call.said.get('callerid')} joins this master and this domain already")


def main() -> None:
    """Run the bridge until it is shut down."""
    if "--print-pairs" in sys.argv:
        print_pairs()
        end(0)
    refuse_second()
    run("ros2_bridge", Bridge)
