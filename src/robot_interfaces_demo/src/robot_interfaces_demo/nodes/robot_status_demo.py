"""A robot and a fleet monitor in one process."""

from nodekit import Node, run
from robot_interfaces_demo.nodes.fleet_monitor import FleetMonitor
from robot_interfaces_demo.nodes.robot_monitor import RobotMonitor


class RobotStatusDemo:
    """Host of the nodes ``robot_monitor`` and ``fleet_monitor``."""

    def __init__(self, node: Node) -> None:
        node.host("robot_monitor", "", RobotMonitor)
        node.host("fleet_monitor", "", FleetMonitor)


def main() -> None:
    """Run both until they are shut down."""
    run("robot_status_demo", RobotStatusDemo)
