"""Reader of the ROS 2 graph (nodes, topics, services), without the bridge's own nodes."""

import collections
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Set, Tuple

from rclpy.qos import ReliabilityPolicy

from nodekit import RoundRobin
from ros2_bridge.ros2.participant import Participant, keeps
from ros2_bridge.rules.selection import ROSOUT, is_reserved
from ros2_bridge.rules.renaming import Renaming

#: Most of the bridge's own topics for which one poll searches other users.
_TOGETHER = 50


class Topic(NamedTuple):
    """A topic as used by other participants.

    :param types: ``package/msg/Name`` of each of its publishers
    :param publishers: ROS 1 names of the publishing nodes
    :param senders: ids of the publishers, 16 bytes each
    :param subscribers: ROS 1 names of the subscribing nodes
    :param definitions: for publishers (True) and subscribers (False): the type, the hash of its
        definition and the ROS 2 name of the node
    :param offers: for transient-local publishers (True) and volatile ones (False), if there are
        any: whether one is best-effort
    """

    types: Set[str]
    publishers: Set[str]
    senders: Set[bytes]
    subscribers: Set[str]
    offers: Dict[bool, bool]
    definitions: Set[Tuple[bool, str, str, str]]

    @property
    def latched(self) -> bool:
        """Whether a publisher is transient-local."""
        return True in self.offers


class Ros2Graph:
    """Reader of the ROS 2 graph; all names are ROS 1 names.

    :param participant: the bridge in ROS 2, excluded from all results
    :param names: renaming rules

    :ivar nameless: names without a ROS 1 name, because another name maps to it
    :ivar shared_names: ROS 2 names of several nodes; ROS 2 reports the services of only one of
        these nodes
    """

    def __init__(self, participant: Participant, names: Renaming) -> None:
        self._participant, self._names = participant, names
        self.nameless: Set[str] = set()
        self.shared_names: Set[str] = set()
        self._round_robin = RoundRobin(_TOGETHER)
        #: Own topics that others use, too, as far as known.
        self._shared: Set[str] = set()

    def _named(self, name: str) -> Optional[str]:
        """Return the ROS 1 name; names that each side uses for itself are unchanged."""
        if is_reserved(name):
            return name
        found = self._names.in_ros1(name)
        if found is None:
            self.nameless.add(name)
        return found

    def _node_of(self, endpoint: Any) -> str:
        """Return the ROS 1 name of an endpoint's node, or else its ROS 2 name."""
        name = _name_of(endpoint)
        return self._names.in_ros1(name) or name

    def topics(self) -> Dict[str, Topic]:
        """Return the topics used by others."""
        found = {}
        for name in self._used():
            publishers = self._others(self._participant.node.get_publishers_info_by_topic(name))
            subscribers = self._others(self._participant.node.get_subscriptions_info_by_topic(name))
            if not publishers and not subscribers:
                continue
            offers: Dict[bool, bool] = {}
            for each in publishers:
                may_lose = each.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
                offers[keeps(each)] = may_lose or offers.get(keeps(each), False)
            name_in_ros1 = self._named(name)
            if name_in_ros1 is None:
                continue
            found[name_in_ros1] = Topic(
                {each.topic_type for each in publishers or subscribers},
                set(map(self._node_of, publishers)),
                {bytes(each.endpoint_gid) for each in publishers},
                set(map(self._node_of, subscribers)),
                offers,
                {
                    (publishes, each.topic_type, str(each.topic_type_hash), _name_of(each))
                    for publishes, endpoints in ((True, publishers), (False, subscribers))
                    for each in endpoints
                },
            )
        return found

    def _used(self) -> Set[str]:
        """Return the names of topics used by others.

        For each query about a topic, rmw scans all endpoints, so the bridge's own topics, possibly
        thousands, are not queried one by one. Instead, each node's topics are queried. DDS programs
        without a node are found by checking a few own topics per poll.
        """
        node, ours = self._participant.node, self._participant.topics()
        names = {name for name, _ in node.get_topic_names_and_types()} - ours
        names |= self._shared.union(self._round_robin.next(sorted(ours)))
        for other in self._all_nodes():
            for ask in (
                node.get_publisher_names_and_types_by_node,
                node.get_subscriber_names_and_types_by_node,
            ):
                names.update(name for name, _ in _asked(ask, other))
        used = {
            name for name in names if _is_of_use(name) and not self._participant.is_alone_with(name)
        }
        self._shared = used & ours
        return used

    def _all_nodes(self) -> Set[str]:
        """Return the ROS 2 names of all nodes of others."""
        names = self._participant.node.get_node_names_and_namespaces()
        found = collections.Counter(f"{space.rstrip('/')}/{name}" for name, space in names)
        own = self._participant.own_names()
        self.shared_names.update(
            name for name, count in found.items() if count > 1 and not _is_hidden(name)
        )
        self.shared_names -= own
        return set(found) - own

    def _others(self, endpoints: List[Any]) -> List[Any]:
        return [one for one in endpoints if not self._participant.is_own(bytes(one.endpoint_gid))]

    def nodes(self) -> Set[str]:
        """Return the names of the nodes of others."""
        theirs = {name for name in self._all_nodes() if not _is_hidden(name)}
        return {name for name in map(self._named, theirs) if name is not None}

    def services(self, nodes: Set[str]) -> Dict[str, Tuple[str, str]]:
        """Return type and node of each service of the given ROS 2 nodes."""
        found = {}
        for node in sorted(nodes):  # of several servers, always use the same
            ask = self._participant.node.get_service_names_and_types_by_node
            for name, types in _asked(ask, self._names.in_ros2(node) or node):
                name_in_ros1 = self._named(name)
                if name_in_ros1 is not None:
                    found[name_in_ros1] = (types[0], node)
        return found


def _name_of(endpoint: Any) -> str:
    """Return the ROS 2 name of an endpoint's node."""
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def _asked(ask: Callable[[str, str], Any], node: str) -> List[Any]:
    """Return rclpy's names and types of a node; empty if the node has just disappeared."""
    namespace, _, base = node.rpartition("/")
    try:
        return list(ask(base, namespace or "/"))
    except Exception:  # rclpy's own
        return []


def _is_of_use(topic: str) -> bool:
    """Return whether to search for users of a topic: not of reserved ones, except /rosout."""
    return topic == ROSOUT or not is_reserved(topic)


def _is_hidden(name: str) -> bool:
    return any(part.startswith("_") for part in name.split("/"))
