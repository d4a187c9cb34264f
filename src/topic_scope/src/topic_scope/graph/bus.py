"""Ask nodes how many messages they have sent: they keep count, and nothing has to be subscribed."""

import time
import xmlrpc.client
from typing import Any, Collection, Dict, Tuple

import rosgraph

#: Longest wait for a node, and the time for which one that did not answer is left alone, s.
TIMEOUT_S, PAUSE_S = 1.0, 10.0


class Transport(xmlrpc.client.Transport):
    """HTTP that gives up after a time."""

    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


class Bus:
    """Asks the nodes of a graph.

    :param caller: name of the node that asks
    """

    def __init__(self, caller: str) -> None:
        self._caller = caller
        self._master = rosgraph.Master(caller)
        self._uris: Dict[str, str] = {}
        self._paused: Dict[str, float] = {}

    def ask(self, nodes: Collection[str]) -> Dict[str, Tuple[float, Any]]:
        """Return what nodes answer to ``getBusStats``, and when; of those that do.

        :param nodes: their names
        """
        answers = {}
        for node in nodes:
            if time.monotonic() < self._paused.get(node, 0.0):
                continue
            try:
                if node not in self._uris:
                    self._uris[node] = self._master.lookupNode(node)
                with xmlrpc.client.ServerProxy(self._uris[node], transport=Transport()) as proxy:
                    code, _, answer = proxy.getBusStats(self._caller)  # type: ignore[misc]
                if code == 1:
                    answers[node] = (time.monotonic(), answer)
            except Exception:  # whatever a node that is ending, or is none, may answer
                self._uris.pop(node, None)
                self._paused[node] = time.monotonic() + PAUSE_S
        self._uris = {node: uri for node, uri in self._uris.items() if node in nodes}
        self._paused = {node: end for node, end in self._paused.items() if node in nodes}
        return answers
