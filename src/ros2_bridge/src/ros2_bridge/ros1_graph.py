"""What others have in ROS 1: nodes, topics and services."""

from typing import Dict, NamedTuple, Set

from nodekit.live.master import MasterClient, Registrations


class Ros1Graph(NamedTuple):
    """One look at the graph, without the bridge itself.

    :param publishers, subscribers: names of nodes by topic
    :param types: of topics, by topic
    :param services: name of the node by service
    :param master_pid: process id of the master: another one has forgotten everything
    """

    publishers: Dict[str, Set[str]]
    subscribers: Dict[str, Set[str]]
    types: Dict[str, str]
    services: Dict[str, str]
    master_pid: int

    def nodes(self) -> Set[str]:
        """Return the names of all nodes that publish, subscribe or serve."""
        by_topic = (*self.publishers.values(), *self.subscribers.values())
        return {*self.services.values(), *(node for nodes in by_topic for node in nodes)}


def look(client: MasterClient, own: Set[str]) -> Ros1Graph:
    """Ask the master.

    :param client: asks it
    :param own: names of nodes that are the bridge's
    :raises MasterUnreachable: if it does not answer
    """

    def others(part: Registrations) -> Dict[str, Set[str]]:
        found = {name: set(nodes) - own for name, nodes in part}
        return {name: nodes for name, nodes in found.items() if nodes}

    state, types = client.system_state(), client.topic_types()
    pid = client.request([("getPid",)])[0][2]
    services = {name: min(nodes) for name, nodes in others(state.services).items()}
    return Ros1Graph(others(state.publishers), others(state.subscribers), types, services, pid)
