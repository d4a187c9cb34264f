"""Ask nodes themselves for what the master does not know.

They keep count of the messages that they send, so that nothing has to be subscribed to. And they
know which type they take: the master has one type for each topic only, that of the first node,
and it stays when a node starts again with another one.
"""

import time
import xmlrpc.client
from typing import Any, Collection, Dict, Optional, Tuple

from nodekit.master import MasterClient

#: Longest wait for a node, and the time for which one that did not answer is left alone [s].
TIMEOUT_S, PAUSE_S = 1.0, 10.0
_SUCCESS = 1


class _Transport(xmlrpc.client.Transport):
    """HTTP that gives up after a time."""

    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


class NodeQueries:
    """Asks the nodes of a graph; its methods wait for them.

    :param caller: name of the node that asks
    """

    def __init__(self, caller: str) -> None:
        self._caller = caller
        self._master = MasterClient(caller)
        self._uris: Dict[str, str] = {}
        self._paused: Dict[str, float] = {}

    def message_counts(self, nodes: Collection[str]) -> Dict[str, Tuple[float, Any]]:
        """Return what nodes answer to ``getBusStats``, and when; of those that do.

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
            except Exception:  # of any kind: a node that is shutting down may reply anything
                self._uris.pop(node, None)
                self._paused[node] = time.monotonic() + PAUSE_S
        return answers

    def subscribed_type(
        self, topic: str, nodes: Collection[str], known: Collection[str]
    ) -> Optional[str]:
        """Return the type that the subscribers of a topic take.

        :param topic: the topic
        :param nodes: its subscribers
        :param known: types that count; what subscribes to any type does not
        :returns: the first such type, None if no subscriber takes any
        """
        for node in sorted(nodes):
            try:
                subscriptions = self._ask(self._look_up(node), "getSubscriptions")
                types = [datatype for name, datatype in subscriptions if name == topic]
            except Exception:  # of any kind: a node that is shutting down may reply anything
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
