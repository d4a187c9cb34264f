"""Bridge node: offers the topics, services and actions of each ROS in the other."""

import sys
from typing import Any, Callable, Dict, List

import yaml

from nodekit import Node, ParameterError, run
from nodekit.entry_point import end
from ros2_bridge.environment.ros1_messages import String, Trigger
from ros2_bridge.graph_loop import GraphLoop
from ros2_bridge.ros1.single_instance import marker, exit_if_second
from ros2_bridge.rules.settings import BridgeParameters
from ros2_bridge.rules.skip_log import Unbridgeable
from ros2_bridge.types.mapping_rules import MappingRuleError
from ros2_bridge.types.type_registry import TypeRegistry


class Bridge:
    """Bridge of topics, services, actions, parameters and managed nodes between ROS 1 and ROS 2.

    :ROS Publishers:
        - ``~statistics`` (std_msgs/String): counters of all topics once a second, as YAML
        - ``/diagnostics`` (diagnostic_msgs/DiagnosticArray): health once a second, also in ROS 2

    :ROS Services:
        - ``~report`` (std_srvs/Trigger): whether all is well, and a table
        - ``/ros2_bridge_of_domain_N`` (std_srvs/Trigger): returns the bridge's name

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.BridgeParameters`; ``~qos`` and
          ``~mappings``, read at startup
    """

    def __init__(self, node: Node) -> None:
        parameters = node.declare_parameters(BridgeParameters, exempt=("qos", "mappings"))
        self._loop = GraphLoop(node, parameters)
        self._statistics = node.create_publisher("~statistics", String)
        node.create_timer(1.0, self._publish, steady=True)
        node.create_service("~report", Trigger, lambda _: self._loop.report())
        node.create_service(marker(), Trigger, lambda _: (True, node.name))

    def _publish(self, _: float) -> None:
        self._loop.update_health()
        if self._statistics.get_num_connections():
            self._statistics.publish(String(yaml.safe_dump(self._loop.statistics())))


def print_pairs(arguments: List[str]) -> None:
    """Print each pair of types; on standard error, types with the same name that differ.

    :param arguments: optionally the name of a YAML file with mapping rules
    """
    if len(arguments) > 1:
        end(f"bridge: --print-pairs: unexpected argument {arguments[1]}; give at most one file")
    try:
        types = TypeRegistry(read_rules(arguments[0]) if arguments else None)
    except (OSError, ParameterError, ValueError, yaml.YAMLError) as error:
        end(f"bridge: --print-pairs: {' '.join(str(error).split())}")  # YAML errors span lines
    finders: Dict[str, Callable[[str], Any]] = {
        "msg": types.message,
        "srv": types.service,
        "action": types.action,
    }
    for kind, name in types.candidates():
        try:
            other = finders[kind](name).ros2
        except Unbridgeable as reason:
            print(f"not bridged: {reason}", file=sys.stderr)
            continue
        package, _, base = other.partition("/")
        print(f"{name} <=> {package}/{kind}/{base}")


def read_rules(path: str) -> Any:
    """Return the mapping rules in a file, as for ``mappings_file:=``.

    :raises OSError: if the file cannot be read
    :raises yaml.YAMLError: if it is not valid YAML
    :raises ValueError: if it does not consist of ``mappings``
    """
    with open(path, encoding="utf-8") as file:
        found = yaml.safe_load(file)
    if not isinstance(found, dict) or set(found) != {"mappings"}:
        raise ValueError(f"{path}: must contain mappings, a list of rules, and nothing else")
    return found["mappings"]


def print_draft(names: List[str]) -> None:
    """Print a draft of a mapping rule for two types.

    :param names: the ROS 1 type, ``package/Name``, and the ROS 2 type, ``package/msg/Name``
    """
    if len(names) != 2:
        end("bridge: --draft-mapping needs a ROS 1 type and a ROS 2 type, such as a/Arm b/msg/Arm")
    try:
        rule = TypeRegistry().draft(*names)
    except MappingRuleError as error:
        end(f"bridge: --draft-mapping: {error.allowed}")
    except Unbridgeable as reason:
        end(f"bridge: --draft-mapping: {reason}")
    print(yaml.safe_dump({"mappings": [rule]}, sort_keys=False), end="")


def main() -> None:
    """Run the bridge until it is shut down."""
    if "--print-pairs" in sys.argv:
        print_pairs(sys.argv[sys.argv.index("--print-pairs") + 1 :])
        return
    if "--draft-mapping" in sys.argv:
        print_draft(sys.argv[sys.argv.index("--draft-mapping") + 1 :])
        return
    exit_if_second()
    run("ros2_bridge", Bridge)
