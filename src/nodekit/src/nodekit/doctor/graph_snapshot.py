# Pure: knows no ROS.
"""Data classes of the surveyed graph: state of each node, and reply of each publisher."""

import dataclasses
from typing import Dict, FrozenSet, List, Optional, Tuple

#: Names of topics, each with the names of its nodes.
Registrations = List[Tuple[str, List[str]]]


def is_loopback(host: str) -> bool:
    """Return whether a host is a name of the loopback device."""
    return host in ("localhost", "::1", "[::1]") or host.startswith("127.")


@dataclasses.dataclass(frozen=True)
class NodeState:
    """State of a registered node, from its own reply.

    :param uri: URI that it has registered
    :param host: host of this URI
    :param is_local: whether this host is the machine of the check
    :param error: why the node does not answer; empty if it does
    :param remedy: what to do about that
    :param pid: its process, None if it does not answer
    :param subscriptions: type by topic
    :param links: pairs of a topic and the name of a subscriber, or the URI of a publisher, that it
        is connected to; None if it does not list them
    :param has_proxy: whether another node has its connections, as the bridge has those of ROS 2
    """

    uri: str
    host: str
    is_local: bool
    error: str = ""
    remedy: str = ""
    pid: Optional[int] = None
    subscriptions: Dict[str, str] = dataclasses.field(default_factory=dict)
    links: Optional[FrozenSet[Tuple[str, str]]] = None
    has_proxy: bool = False


@dataclasses.dataclass(frozen=True)
class Publication:
    """Reply of one publisher of a topic to a subscriber.

    :param type_name: type of its messages
    :param md5sum: checksum of their definition
    :param stamp: time stamp of a message that it sent meanwhile [s], None without one
    :param received_at: wall time at which that message was received [s]
    """

    type_name: str
    md5sum: str
    stamp: Optional[float] = None
    received_at: float = 0.0


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """The graph at one moment.

    :param publishers: names of publishing nodes, by topic
    :param subscribers: names of subscribing nodes, by topic
    :param nodes: the nodes, by name
    :param publications: answers of publishers, by topic and name of the node
    :param types: type of each topic as the master knows it
    """

    publishers: Dict[str, List[str]]
    subscribers: Dict[str, List[str]]
    nodes: Dict[str, NodeState]
    publications: Dict[Tuple[str, str], Publication] = dataclasses.field(default_factory=dict)
    types: Dict[str, str] = dataclasses.field(default_factory=dict)
