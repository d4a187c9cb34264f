"""Snapshot of the ROS 1 graph (nodes, topics, services), without the bridge's own nodes."""

from typing import Dict, NamedTuple, Set

from nodekit import MasterUnreachable
from nodekit.master import MasterClient, Registrations


class Ros1Graph(NamedTuple):
    """Snapshot of the ROS 1 graph, without the bridge itself.

    :param publishers, subscribers: names of nodes by topic
    :param types: types of the published topics; ``*`` if no publisher announces it
    :param services: name of the node by service
    :param master_pid: process id of the master; it changes when the master restarts
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


def read_graph(client: MasterClient, own: Set[str]) -> Ros1Graph:
    """Read the graph from the master in one request; an unchanged reply is not parsed again.

    The types of all topics are not requested: the master never forgets them, even when the topics
    are gone.

    :param client: client of the master; it caches two replies, so use it for little else
    :param own: names of the bridge's nodes
    :raises MasterUnreachable: if the master does not answer
    """

    def others(part: Registrations) -> Dict[str, Set[str]]:
        found = {name: set(nodes) - own for name, nodes in part}
        return {name: nodes for name, nodes in found.items() if nodes}

    state, types, pid = client.request(
        [("getSystemState",), ("getPublishedTopics", ""), ("getPid",)]
    )
    try:
        publishers, subscribers, services = map(others, state[2])
        servers = {name: min(nodes) for name, nodes in services.items()}
        return Ros1Graph(publishers, subscribers, dict(types[2]), servers, pid[2])
    except (TypeError, ValueError):
        raise MasterUnreachable(f"malformed reply of the master: {state!r:.80}") from None
