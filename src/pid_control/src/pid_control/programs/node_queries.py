"""Queries of other nodes: types of their topics, and connections."""

import xmlrpc.client
from typing import Any, Dict, NamedTuple, Set

from nodekit.master import TimeoutTransport

#: Longest wait for an answer of a node [s].
_NODE_S = 2.0


class NodeTopics(NamedTuple):
    """Types of a node's topics.

    :ivar published: type of each topic that it publishes
    :ivar subscribed: type of each topic that it subscribes to
    """

    published: Dict[str, str]
    subscribed: Dict[str, str]


def ask_topics(caller: str, uri: str) -> NodeTopics:
    """Ask a node for the types of its topics.

    :param caller: name of the caller
    :param uri: XML-RPC URI of the node
    :raises ConnectionRefusedError: if it has ended
    :raises Exception: of any type, if it does not answer as a node would
    """
    with xmlrpc.client.ServerProxy(uri, transport=TimeoutTransport(_NODE_S)) as proxy:
        answers: Any = (proxy.getPublications(caller), proxy.getSubscriptions(caller))
    found = [{str(name): str(msg_type) for name, msg_type in one[2]} for one in answers]
    return NodeTopics(found[0], found[1])


def ask_links(caller: str, uri: str) -> Set[str]:
    """Return the topics that a node receives over a connection.

    :param caller: name of the caller
    :param uri: XML-RPC URI of the node
    :raises Exception: of any type, if it does not answer as a node would
    """
    with xmlrpc.client.ServerProxy(uri, transport=TimeoutTransport(_NODE_S)) as proxy:
        answer: Any = proxy.getBusInfo(caller)
    # id, node at the other end, direction, transport, topic, whether it is connected (optional)
    return {str(one[4]) for one in answer[2] if one[2] == "i" and (len(one) < 6 or one[5])}
