"""The names of ROS 2's nodes in ROS 1's list of nodes.

The master lists whoever has registered something. Each node of ROS 2 is registered as a subscriber
of /parameter_events, which it has there too; what the master then tells it, the bridge gets, and
has no use for. To be registered as publishers would have subscribers connect to the bridge twice.
"""

import contextlib
from typing import Set

import rosgraph
import rospy

from nodekit.live.master import MasterClient

_TOPIC, _TYPE = "/parameter_events", "rcl_interfaces/ParameterEvent"


class NamesInRos1:
    """Registers names with the master, and takes them back.

    :ivar names: those that are registered: they are no nodes of ROS 1
    """

    def __init__(self) -> None:
        self.names: Set[str] = set()

    def look(self, nodes: Set[str], is_restarted: bool) -> None:
        """Register who has come, and take back who has gone.

        :param nodes: names of the nodes of ROS 2
        :param is_restarted: whether the master has forgotten all
        :raises MasterUnreachable: if it does not answer
        """
        if is_restarted:
            self.names = set()
        for name in self.names - nodes:
            self._ask(name, "unregisterSubscriber", _TOPIC)
        self.names &= nodes
        for name in nodes - self.names:
            self.names.add(name)
            self._ask(name, "registerSubscriber", _TOPIC, _TYPE)

    def close(self) -> None:
        """Take all of them back, if the master answers."""
        with contextlib.suppress(ConnectionError):
            self.look(set(), False)

    def _ask(self, name: str, *call: str) -> None:
        uri = rospy.get_node_uri()
        with contextlib.closing(MasterClient(rosgraph.get_master_uri(), name, uri, 1.0)) as client:
            client.request([(*call, uri)])
