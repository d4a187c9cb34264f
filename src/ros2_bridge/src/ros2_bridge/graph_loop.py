"""Loop that polls both graphs and updates each part of the bridge."""

import contextlib
import os
import threading
import time
import traceback
from typing import Any, Dict, Iterator, Set, Tuple

import rospy

from nodekit import LiveParameters, MasterUnreachable, Node, Throttle
from nodekit.master import MISSING, MasterClient
from ros2_bridge.action_bridge.all_actions import ActionBridge
from ros2_bridge.diagnostics import Diagnostics
from ros2_bridge.health.reports import BridgeHealth, is_well, statuses, table
from ros2_bridge.health.topic_health import TopicHealthMonitor
from ros2_bridge.node_bridge import NodeBridge
from ros2_bridge.ros1.graph import Ros1Graph, read_graph
from ros2_bridge.ros1.node_registrar import Registration, NodeRegistrar
from ros2_bridge.ros2.graph import Ros2Graph, Topic
from ros2_bridge.ros2.participant import Participant
from ros2_bridge.rules.selection import ROSOUT, is_reserved
from ros2_bridge.rules.active_pairs import PairBridge
from ros2_bridge.rules.settings import BridgeParameters, QosProfiles
from ros2_bridge.rules.skip_log import SkipLog
from ros2_bridge.services import ServiceBridge
from ros2_bridge.topics.all_topics import TopicBridge
from ros2_bridge.topics.robot_description import RobotDescription
from ros2_bridge.topics.rosout import Rosout
from ros2_bridge.types.type_registry import TypeRegistry

#: Period of the loop [s], and number of its iterations per poll.
_TICK_S, _TICKS = 0.1, 5
#: Number of initial polls that happen at every iteration: ROS 2 discovers the graph gradually.
_FIRST_POLLS = 10
#: Timeout for the master [s].
_MASTER_S = 2.0
#: Shortest time between two equal log lines [s].
_LOG_PERIOD_S = 10.0
#: Time without a complete poll after which the bridge reports an error [s].
_STUCK_S = 10.0


class GraphLoop:
    """All parts of the bridge, and the thread that updates them from the graphs.

    :param node: the bridge in ROS 1
    :param parameters: of the bridge
    :raises ParameterError: if a quality of service or a mapping rule is malformed
    """

    def __init__(self, node: Node, parameters: "LiveParameters[BridgeParameters]") -> None:
        self._throttle = Throttle(_LOG_PERIOD_S)
        self._node, self._parameters = node, parameters
        self._master = MasterClient(node.name)
        # A separate client: it caches the latest replies.
        self._poller = MasterClient(node.name, timeout=_MASTER_S)
        qos, mappings = (self._read(node.resolve(name)) for name in ("~qos", "~mappings"))
        # Both may end the process; ROS 2 would list the node of a participant for some time.
        qualities, types = QosProfiles(parameters.values.depth, qos), TypeRegistry(mappings)
        self._renaming = names = parameters.values.names()
        self._participant = participant = Participant(names.in_ros2(node.name) or node.name)
        self._graph, self._skip_log = Ros2Graph(participant, names), SkipLog()
        self._topics = TopicBridge(node, participant, types, qualities, self._skip_log)
        self._description = RobotDescription(node, participant, types, self._skip_log)
        self._nodes = NodeBridge(
            node,
            participant,
            self._master,
            names,
            self._skip_log,
            lambda: parameters.values.integers_for_doubles,
        )
        self._services = ServiceBridge(
            node,
            participant,
            self._poller,
            types,
            self._skip_log,
            lambda: parameters.values.service_timeout,
        )
        self._actions = ActionBridge(
            node, participant, types, self._skip_log, lambda: parameters.values.service_timeout
        )
        self._rosout, self._nodes_in_ros1 = (
            Rosout(node, participant, names),
            NodeRegistrar(node.name),
        )
        self._diagnostics = Diagnostics(node, participant, types, names)
        self._monitor = TopicHealthMonitor()
        self._health = BridgeHealth({}, 0, 0, (), "", 0)
        self._trouble, self._polled_at = "", time.monotonic()
        self._master_pid = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="graph loop", daemon=True)
        self._thread.start()
        node.on_shutdown(self.close)

    def _read(self, name: str) -> Any:
        """Return a parameter, or None if it is not set."""
        value = self._master.read([name]).values[name]
        return None if value is MISSING else value

    def _run(self) -> None:
        tick = 0
        while not self._ended.wait(_TICK_S if self._node.is_up else 0.01):
            if not self._node.is_up:
                continue
            tick += 1
            try:
                with self._guarded():
                    if tick <= _FIRST_POLLS or tick % _TICKS == 0:
                        self._poll_graphs()
                    else:
                        with self._guarded():
                            self._topics.follow_subscribers1()
                        self._actions.follow()
            except MasterUnreachable as error:  # nothing changes until the master is back
                self._trouble = f"nothing new is bridged: {error}"
                if self._throttle.is_due("master"):
                    rospy.logwarn(self._trouble)

    @contextlib.contextmanager
    def _guarded(self) -> Iterator[None]:
        """Log an exception of one part of the bridge; the other parts continue."""
        try:
            yield
        except MasterUnreachable:
            raise
        except Exception:
            if not self._ended.is_set():
                if self._throttle.is_due("exception"):
                    rospy.logerr(traceback.format_exc())

    def _poll_graphs(self) -> None:
        ros1 = self._read_ros1()
        if self._nodes_in_ros1.remove_stale(ros1):
            ros1 = self._read_ros1()
        is_restarted = self._master_pid not in (0, ros1.master_pid)
        self._master_pid = ros1.master_pid
        values, in_ros2, topics = self._parameters.values, self._graph.nodes(), self._graph.topics()
        rules = values.bridged(self._renaming)
        services = self._graph.services(in_ros2)
        self._nodes.offer_own_parameters()
        parameters, most = values.parameters, values.max_nodes
        self._nodes.update_nodes(ros1, in_ros2, services, parameters, most, is_restarted)
        owners = self._nodes.in_ros2()
        self._rosout.update_nodes(owners)
        self._rosout.subscription.switch(ROSOUT in topics and bool(topics[ROSOUT].subscribers))
        parts: Tuple[PairBridge[Any], ...] = (self._topics, self._services, self._actions)
        for part in parts:
            with self._guarded():
                part.close_denied(rules)
        with self._guarded():
            self._topics.update_topics(rules, ros1, topics, owners)
        with self._guarded():
            self._description.update(rules, ros1, topics)
        with self._guarded():
            self._services.update_services(rules, ros1, services, owners)
        with self._guarded():
            self._actions.update_actions(rules, ros1, services, owners)
        entries = self._entries(in_ros2, topics)
        if self._ended.is_set():
            return
        self._nodes_in_ros1.register(entries, ros1.nodes(), is_restarted)
        self._report_nameless({*ros1.publishers, *ros1.services, *ros1.nodes()})
        self._skip_log.end_poll()
        self._trouble, self._polled_at = "", time.monotonic()
        line = self._skip_log.next_line(time.monotonic())
        if line is not None:
            rospy.logwarn("%s", line)

    def _read_ros1(self) -> Ros1Graph:
        return read_graph(self._poller, {self._node.name, *self._nodes_in_ros1.names})

    def _entries(self, nodes: Set[str], topics: Dict[str, Topic]) -> Dict[str, Set[Registration]]:
        """Return the ROS 1 registrations of each ROS 2 node, by its ROS 1 name.

        :param topics: of ROS 2, by ROS 1 name
        """
        found: Dict[str, Set[Registration]] = {node: set() for node in nodes}
        for route, kind in self._topics.types().items():
            if route.name in topics:
                topic = topics[route.name]
                entry = Registration(
                    "Subscriber" if route.to_ros2 else "Publisher", route.name, kind
                )
                for node in nodes & (topic.subscribers if route.to_ros2 else topic.publishers):
                    found[node].add(entry)
        for name, node in self._services.servers().items():
            found.setdefault(node, set()).add(Registration("Service", name))
        return found

    def _report_nameless(self, in_ros1: Set[str]) -> None:
        for name in in_ros1:
            if self._renaming.in_ros2(name) is None and not is_reserved(name):
                self._skip_log.report(f"{name} of ROS 1: ~remap gives its name in ROS 2 to another")
        for name in self._graph.nameless:
            self._skip_log.report(f"{name} of ROS 2: ~remap gives its name in ROS 1 to another")
        for name in self._graph.shared_names:
            self._skip_log.report(
                f"several nodes of ROS 2 are called {name}, or one that was killed is still listed:"
                " the services and actions of all but one"
            )
        self._graph.nameless.clear()
        self._graph.shared_names.clear()

    def statistics(self) -> Dict[str, Any]:
        """Return the counters of each topic pair."""
        topics: Dict[str, Any] = {"to_ros1": {}, "to_ros2": {}}
        for route, counts in self._topics.counts().items():
            topics["to_ros2" if route.to_ros2 else "to_ros1"][route.name] = counts._asdict()
        return {"topics": topics}

    def update_health(self) -> None:
        """Update the health from all counters, and publish it as diagnostics.

        To be called once a second.
        """
        now = time.monotonic()
        trouble = self._trouble
        if not trouble and now > self._polled_at + _STUCK_S:
            trouble = f"the graphs have not been read for {now - self._polled_at:.0f} s"
        self._health = BridgeHealth(
            self._monitor.update(now, self._topics.counts()),
            len(self._services.pairs),
            len(self._actions.pairs),
            self._skip_log.current(),
            trouble,
            resident_memory(),
        )
        if self._diagnostics.has_subscribers():
            self._diagnostics.publish(statuses(self._health))

    def report(self) -> Tuple[bool, str]:
        """Return whether all is well, and the health at the latest update as a table."""
        return is_well(self._health), table(self._node.name, self._health)

    def close(self) -> None:
        """Close all ROS 2 parts while ROS 1 still exists; rospy then closes that."""
        self._ended.set()
        self._thread.join(0.5)
        for end in (self._actions.end_goals, self._nodes_in_ros1.close, self._participant.close):
            try:
                end()
            except Exception:  # the other parts have to be closed, too
                rospy.logerr(traceback.format_exc())


def resident_memory() -> int:
    """Return the resident memory of this process [bytes]; see proc(5), ``/proc/self/statm``."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
