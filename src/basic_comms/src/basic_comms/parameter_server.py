"""A client of the ROS parameter server with time-outs and batches.

rospy's own client waits for ever on a hung master, caches what it should not
after a cached read, and takes one round trip a key. This one reads or writes
any number of keys in one request. It uses the Master and Parameter Server APIs
only: http://wiki.ros.org/ROS/Master_API, http://wiki.ros.org/ROS/Parameter%20Server%20API.
"""

import http.client
import threading
import xmlrpc.client
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple, Union

_SUCCESS = 1

#: What a request raises where the master does not answer or is not one.
UNREACHABLE = (OSError, http.client.HTTPException, xmlrpc.client.Error)


class Missing:
    """The value of a key that the server does not hold."""

    def __repr__(self) -> str:
        return "MISSING"


MISSING = Missing()


class Reading(NamedTuple):
    """What the server held at one moment.

    :param values: raw value by key, MISSING where nothing is set
    :param knows_node: whether the master knows the node; it has forgotten it
        when it was restarted
    :param master_pid: process id of the master, another sign of a restart
    """

    values: Dict[str, Any]
    knows_node: bool
    master_pid: int


class _Transport(xmlrpc.client.Transport):
    """HTTP that gives up after a time."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(
        self, host: Union[str, Tuple[str, Dict[str, str]]]
    ) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


class ParameterServer:
    """The parameter server as one node sees it; methods may be called from any thread.

    :param master_uri: URI of the master
    :param node_name: name of the node, global
    :param node_uri: XML-RPC URI of the node, where the master sends updates
    :param timeout: longest wait for an answer, s
    """

    def __init__(
        self, master_uri: str, node_name: str, node_uri: str, timeout: float = 5.0
    ) -> None:
        self._master_uri = master_uri
        self._node_name = node_name
        self._node_uri = node_uri
        self._proxy = self._connect(timeout)
        self._lock = threading.Lock()

    def _connect(self, timeout: float) -> xmlrpc.client.ServerProxy:
        return xmlrpc.client.ServerProxy(self._master_uri, transport=_Transport(timeout))

    def read(self, keys: Sequence[str]) -> Reading:
        """Read keys in one request, past every cache.

        :param keys: global names of parameters or namespaces
        :returns: the values, and whether the master knows this node
        :raises UNREACHABLE: if the master does not answer
        """
        calls: List[Tuple[Any, ...]] = [("lookupNode", self._node_name), ("getPid",)]
        calls += [("getParam", key) for key in keys]
        node, pid, *answers = self._request(calls)
        values = {
            key: value if code == _SUCCESS else MISSING
            for key, (code, _, value) in zip(keys, answers)
        }
        return Reading(values, node[0] == _SUCCESS, pid[2])

    def write(self, values: Mapping[str, Any]) -> None:
        """Set keys in one request. The master does not notify the writing node.

        :param values: raw value by global name
        :raises UNREACHABLE: if the master does not answer
        """
        self._request([("setParam", key, value) for key, value in values.items()])

    def subscribe(self, keys: Iterable[str]) -> None:
        """Have the master send changes of these keys, and below them, to the node.

        :param keys: global names of parameters or namespaces
        :raises UNREACHABLE: if the master does not answer
        """
        self._request([("subscribeParam", self._node_uri, key) for key in keys])

    def unsubscribe(self, keys: Iterable[str], timeout: float = 0.5) -> None:
        """Take subscriptions back, over a connection of its own.

        Meant for shut-down, which may have interrupted the very thread that
        holds the lock of the shared connection.

        :param keys: global names, as they were subscribed
        :param timeout: longest wait for an answer, s
        :raises UNREACHABLE: if the master does not answer
        """
        calls = xmlrpc.client.MultiCall(self._connect(timeout))
        for key in keys:
            calls.unsubscribeParam(self._node_name, self._node_uri, key)
        calls()

    def _request(self, calls: Sequence[Tuple[Any, ...]]) -> List[Any]:
        if not calls:
            return []
        with self._lock:
            batch = xmlrpc.client.MultiCall(self._proxy)
            for method, *arguments in calls:
                getattr(batch, method)(self._node_name, *arguments)
            answers = batch()
            return [answers[i] for i in range(len(calls))]
