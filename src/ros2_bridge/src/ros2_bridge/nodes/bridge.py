"""The bridge: what is there in one ROS, is there in the other."""

import sys

import yaml

from nodekit import Node, run
from ros2_bridge.environment.ros1 import String, Trigger
from ros2_bridge.looking import Looking
from ros2_bridge.ros1.one_bridge import marker, refuse_second
from ros2_bridge.rules.settings import BridgeParameters
from ros2_bridge.types.print_pairs import print_pairs


class Bridge:
    """Bridges topics, services, parameters and managed nodes between ROS 1 and ROS 2.

    :ROS Publishers:
        - ``~statistics`` (std_msgs/String): each second what has gone through, as YAML

    :ROS Services:
        - ``/ros2_bridge_of_domain_N`` (std_srvs/Trigger): tells the bridge's name

    :ROS Parameters:
        - those of :class:`.BridgeParameters`, private and live; and ``~qos``, read at the start
    """

    def __init__(self, node: Node) -> None:
        parameters = node.parameters(BridgeParameters, exempt=("qos",))
        self._looking = Looking(node, parameters)
        self._statistics = node.publisher("~statistics", String)
        node.every(1.0, self._publish_statistics, steady=True)
        node.service(marker(), Trigger, lambda _: (True, node.name))

    def _publish_statistics(self, _: float) -> None:
        if self._statistics.get_num_connections():
            self._statistics.publish(String(yaml.safe_dump(self._looking.statistics())))


def main() -> None:
    """Run the bridge until it is shut down."""
    if "--print-pairs" in sys.argv:
        print_pairs()
        return
    refuse_second()
    run("ros2_bridge", Bridge)
