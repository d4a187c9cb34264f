"""Queries to the slave API of nodes, for data that the master does not have.

Nodes count the messages that they send, so rates need no subscriptions. And a subscriber knows the
type that it expects: the master stores only one type per topic, the type of the first node, and
keeps it when a node restarts with another type.
"""

import time
import xmlrpc.client
from typing import Any, Collection, Dict, Optional, Tuple

from nodekit.master import MasterClient

#: Timeout of a query, and the time for which an unresponsive node is skipped [s].
TIMEOUT_S, PAUSE_S = 1.0, 10.0
_SUCCESS = 1


class _Transport(xmlrpc.client.Transport):
    """HTTP transport with a timeout."""

    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


class NodeQueries:
    """Blocking queries to the nodes of a graph.

    :param caller: name of the calling node
    """

    def __init__(self, caller: str) -> None:
        self._caller = caller
        self._master = MasterClient(caller)
        self._uris: Dict[str, str] = {}
        self._paused: Dict[str, float] = {}

    def message_counts(self, nodes: Collection[str]) -> Dict[str, Tuple[float, Any]]:
        """Return the replies of nodes to ``getBusStats``, with their times.

        :param nodes: their names
        """
        self._uris = {node: uri for node, uri in self._uris.items() if node in nodes}
        self._paused = {node: end for node, end in self._paused.items() if node in nodes}
        answers = {}
        for node in nodes:
            if time.monotonic() < self._paused.get(node, 0.0):
                continue
            try:
                if node not in self._uris:
                    self._uris[node] = self._look_up(node)
                statistics = self._ask(self._uris[node], "getBusStats")
                answers[node] = (time.monotonic(), statistics)
            except Exception:  # a node that is shutting down may reply anything
                self._uris.pop(node, None)
                self._paused[node] = time.monotonic() + PAUSE_S
        return answers

    def subscribed_type(
        self, topic: str, nodes: Collection[str], known: Collection[str]
    ) -> Optional[str]:
        """Return the type that the subscribers of a topic expect.

        :param topic: the topic
        :param nodes: its subscribers
        :param known: accepted types; subscribers to any type are ignored
        :returns: the first accepted type; None without one
        """
        for node in sorted(nodes):
            try:
                subscriptions = self._ask(self._look_up(node), "getSubscriptions")
                types = [datatype for name, datatype in subscriptions if name == topic]
            except Exception:  # a node that is shutting down may reply anything
                continue
            for datatype in types:
                if datatype in known:
                    return str(datatype)
        return None

    def _look_up(self, node: str) -> str:
        uri = self._master.lookup_node(node)
        if uri is None:
            raise LookupError(f"the master does not know {node}")
        return uri

    def _ask(self, uri: str, method: str) -> Any:
        """Call a method of a node's slave API, http://wiki.ros.org/ROS/Slave_API."""
        with xmlrpc.client.ServerProxy(uri, transport=_Transport()) as proxy:
            code, text, answer = getattr(proxy, method)(self._caller)
        if code != _SUCCESS:
            raise LookupError(text)
        return answer
