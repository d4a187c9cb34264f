"""Runs the queries of the ``ros2`` command line, and records their output.

PyPI does not have that command line. Parts that differ between runs are omitted, or rounded.
"""

import contextlib
import statistics
import threading
import time
from typing import Any, Callable, Dict, List, Set, Tuple

import both
import rclpy
from action_answers import ACTION, ROBOT, ActionAnswers
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import get_parameter_value
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from basic_comms.msg import SignalMsg
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from nodekit.testing.waiting import TIMEOUT_S, wait_until

GENERATOR, MANAGED = "/signal_generator", "/managed"
#: All parameters of the generator's twin.
PARAMETERS = ("amplitude", "rate")
#: Parameters that rclpy itself gives a node.
_OF_RCLPY = ("use_sim_time", "start_type_description_service")
#: Services that are listed last: of each node, and of the generator.
_LAST = ("describe_parameters", "set_parameters_atomically")
_OFFERED = ("reset", "enable", *_LAST)
#: Topics that every node publishes.
_OF_ALL = ("/rosout", "/parameter_events")
#: Nodes of the tests themselves.
OF_TESTS = ("/tests", "/ros2_tests")
_KINDS = ("", "Boolean", "Integer", "Double", "String")
_FIELDS = ("", "bool_value", "integer_value", "double_value", "string_value")
_TYPES = ("", "boolean", "integer", "double", "string")


class Answers:
    """Queries to the nodes of a ROS 2 domain.

    :param domain: its id
    """

    def __init__(self, domain: int) -> None:
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain)
        self.node = Node(f"_asking{domain}", context=self._context, enable_rosout=False)
        self._actions = ActionAnswers(self.node, self._nodes)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            while self._context.ok():
                with contextlib.suppress(both.InvalidHandle):
                    self._executor.spin()

    def close(self) -> None:
        """End the clients."""
        rclpy.shutdown(context=self._context)
        self._thread.join(5.0)

    def all(self) -> Dict[str, List[str]]:
        """Return the output of each command, as lines, in the order of the commands."""
        return {f"ros2 {words}": ask() for words, ask in self._commands()}

    def _commands(self) -> List[Tuple[str, Callable[[], List[str]]]]:
        of, managed = GENERATOR, MANAGED
        return [
            ("node list", self._nodes),
            (f"node info {of}", lambda: self._node_info("signal_generator")),
            (f"node info {ROBOT}", lambda: self._node_info(ROBOT[1:])),
            ("topic list -t", self._topics),
            ("topic info -v /signal", lambda: self._topic_info("/signal")),
            ("topic info -v /signal_generator/status", lambda: self._topic_info(f"{of}/status")),
            ("topic echo --once /signal", lambda: self._echo(SignalMsg, "/signal")),
            (f"topic echo --once {of}/status", lambda: self._echo(String, f"{of}/status")),
            ("topic hz /signal", self._rate),
            (f"param list {of}", lambda: self._parameters(of)),
            (f"param get {of} amplitude", lambda: self._get("amplitude")),
            (f"param get {of} nonsense", lambda: self._get("nonsense")),
            (f"param describe {of} amplitude", lambda: self._describe("amplitude")),
            (f"param set {of} amplitude 3.0", lambda: self._set("amplitude", "3.0")),
            (f"param set {of} amplitude 3", lambda: self._set("amplitude", "3")),
            (f"param set {of} amplitude high", lambda: self._set("amplitude", "high")),
            (f"param set {of} amplitude -1.0", lambda: self._set("amplitude", "-1.0")),
            (f"param set {of} nonsense 1", lambda: self._set("nonsense", "1")),
            ("service list -t", self._services),
            (f"service call {of}/reset std_srvs/srv/Trigger", self._call_reset),
            ("lifecycle nodes", self._managed_nodes),
            (f"lifecycle get {managed}", self._state),
            (f"lifecycle list {managed}", self._transitions),
            (f"lifecycle set {managed} activate", lambda: self._transit("activate")),
            (f"lifecycle set {managed} configure", lambda: self._transit("configure")),
            (f"lifecycle set {managed} 3", lambda: self._transit("3")),
            *self._actions.commands(),
        ]

    def wait_for_nodes(self) -> None:
        """Wait until all nodes exist, with all queried entities."""
        own = {GENERATOR: ("status", *_OFFERED), ROBOT: _LAST}
        wanted = {of: {*_OF_ALL, *(f"{of}/{name}" for name in names)} for of, names in own.items()}
        wanted[GENERATOR].add("/signal")
        states = f"{MANAGED}/get_available_transitions"

        def missing() -> Set[str]:
            if states not in {name for name, _ in self.node.get_service_names_and_types()}:
                return {states}
            if not self._actions.is_there():
                return {ACTION}
            # An entity may be discovered before its node.
            return set().union(*(names - self._made_by(of) for of, names in wanted.items()))

        wait_until(lambda: not missing(), lambda: f"{missing()} of {self._nodes()}")

    def _made_by(self, node: str) -> Set[str]:
        """Return the topics and services that are known to be of a node."""
        found: Set[str] = set()
        with contextlib.suppress(Exception):  # rclpy's own, where there is no such node yet
            for ask in (
                self.node.get_publisher_names_and_types_by_node,
                self.node.get_service_names_and_types_by_node,
            ):
                found.update(name for name, _ in ask(node[1:], "/"))
        return found

    def _nodes(self) -> List[str]:
        names = self.node.get_node_names_and_namespaces()
        found = {f"{namespace.rstrip('/')}/{name}" for name, namespace in names}
        return sorted(name for name in found.difference(OF_TESTS) if "/_" not in name)

    def _node_info(self, name: str) -> List[str]:
        node = self.node
        lines = [f"/{name}"]
        for title, ask in (
            ("Subscribers", node.get_subscriber_names_and_types_by_node),
            ("Publishers", node.get_publisher_names_and_types_by_node),
            ("Service Servers", node.get_service_names_and_types_by_node),
            ("Service Clients", node.get_client_names_and_types_by_node),
        ):
            found = sorted(ask(name, "/"))
            lines.append(f"  {title}:")
            lines += [f"    {one}: {', '.join(types)}" for one, types in found if "/_" not in one]
        return [*lines, *self._actions.of_node(name)]

    def _topics(self) -> List[str]:
        topics = self.node.get_topic_names_and_types()
        return [f"{name} [{', '.join(types)}]" for name, types in sorted(topics) if _is_asked(name)]

    def _topic_info(self, topic: str) -> List[str]:
        publishers = self.node.get_publishers_info_by_topic(topic)
        types = dict(self.node.get_topic_names_and_types())[topic]
        lines = [f"Type: {', '.join(types)}", f"Publisher count: {len(publishers)}"]
        for one in publishers:
            text = [line for line in str(one).splitlines() if not line.startswith("GID")]
            lines += text
        return [*lines, f"Subscription count: {self.node.count_subscribers(topic)}"]

    def _hear(self, cls: Any, topic: str, count: int) -> List[Any]:
        (one, *_) = self.node.get_publishers_info_by_topic(topic)
        qos = QoSProfile(depth=100, durability=one.qos_profile.durability)
        heard: List[Any] = []
        subscription = self.node.create_subscription(
            cls, topic, lambda message: heard.append((time.monotonic(), message)), qos
        )
        wait_until(lambda: len(heard) >= count, lambda: f"{topic}: {len(heard)} of {count}")
        self.node.destroy_subscription(subscription)
        return heard[:count]

    def _echo(self, cls: Any, topic: str) -> List[str]:
        ((_, message),) = self._hear(cls, topic, 1)
        names = message.get_fields_and_field_types()
        values = {name: getattr(message, name) for name in names}
        changing = ("time_x", "signal_y")
        return [
            *(f"{name}: {'...' if name in changing else value}" for name, value in values.items()),
            "---",
        ]

    def _rate(self) -> List[str]:
        heard = self._hear(SignalMsg, "/signal", 21)
        times = [message.time_x for _, message in heard]
        # By their own times, and the median: a busy machine delays or drops some.
        usual = statistics.median(late - early for early, late in zip(times, times[1:]))
        return [f"average rate: {1.0 / usual:.0f}"]

    def _call(self, cls: Any, name: str, **fields: Any) -> Any:
        client = self.node.create_client(cls, name)
        assert client.wait_for_service(TIMEOUT_S), name
        future = client.call_async(cls.Request(**fields))
        wait_until(future.done, lambda: f"no answer of {name}")
        self.node.destroy_client(client)
        return future.result()

    def _parameters(self, of: str) -> List[str]:
        names = self._call(ListParameters, f"{of}/list_parameters").result.names
        return [f"  {name}" for name in sorted(names) if name in (*PARAMETERS, *_OF_RCLPY)]

    def _get(self, name: str) -> List[str]:
        values = self._call(GetParameters, f"{GENERATOR}/get_parameters", names=[name]).values
        if not values:
            return ["Parameter not set"]
        kind = values[0].type
        return [f"{_KINDS[kind]} value is: {getattr(values[0], _FIELDS[kind])}"]

    def _describe(self, name: str) -> List[str]:
        service = f"{GENERATOR}/describe_parameters"
        (found,) = self._call(DescribeParameters, service, names=[name]).descriptors
        lines = [f"Parameter name: {found.name}", f"  Type: {_TYPES[found.type]}"]
        lines += [f"  Description: {found.description}", "  Constraints:"]
        for limits in (*found.floating_point_range, *found.integer_range):
            lines += [f"    Min value: {limits.from_value}", f"    Max value: {limits.to_value}"]
            lines += [f"    Step: {limits.step}"] if limits.step else []
        if found.additional_constraints:
            lines.append(f"    Additional constraints: {found.additional_constraints}")
        return lines

    def _set(self, name: str, text: str) -> List[str]:
        given = [Parameter(name=name, value=get_parameter_value(text))]
        service = f"{GENERATOR}/set_parameters"
        (result,) = self._call(SetParameters, service, parameters=given).results
        outcome = "Set parameter successful" if result.successful else "Setting parameter failed"
        return [f"{outcome}: {result.reason}" if result.reason else outcome]

    def _services(self) -> List[str]:
        found = sorted(self.node.get_service_names_and_types())
        return [f"{name} [{types[0]}]" for name, types in found if name.startswith(GENERATOR)]

    def _call_reset(self) -> List[str]:
        response = self._call(Trigger, f"{GENERATOR}/reset")
        name = "std_srvs.srv.Trigger_Response"
        return [f"{name}(success={response.success}, message='{response.message}')"]

    def _managed_nodes(self) -> List[str]:
        offered = dict(self.node.get_service_names_and_types())
        return [name for name in self._nodes() if f"{name}/get_state" in offered]

    def _state(self) -> List[str]:
        state = self._call(GetState, f"{MANAGED}/get_state").current_state
        return [f"{state.label} [{state.id}]"]

    def _available(self) -> List[Any]:
        service = f"{MANAGED}/get_available_transitions"
        return list(self._call(GetAvailableTransitions, service).available_transitions)

    def _transitions(self) -> List[str]:
        lines = []
        for one in self._available():
            lines.append(f"- {one.transition.label} [{one.transition.id}]")
            lines += [f"    Start: {one.start_state.label}", f"    Goal: {one.goal_state.label}"]
        return lines

    def _transit(self, text: str) -> List[str]:
        available = [one.transition for one in self._available()]
        wanted = [one for one in available if text in (one.label, str(one.id))]
        if not wanted:
            listed = [f"- {one.label} [{one.id}]" for one in available]
            return ["Unknown transition requested, available ones are:", *listed]
        done = self._call(ChangeState, f"{MANAGED}/change_state", transition=wanted[0])
        return ["Transitioning successful" if done.success else "Transitioning failed"]


def _is_asked(name: str) -> bool:
    """Return whether a topic belongs to the generator, to every node, or to the bridge."""
    return name.startswith("/signal") or name in (*_OF_ALL, "/diagnostics")
