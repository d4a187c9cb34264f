"""A client of the ROS parameter server with time-outs and batches.

rospy's own client waits for ever on a hung master, caches what it should not
after a cached read, and takes one round trip a key. This one reads or writes
any number of keys in one request. It uses the Master and Parameter Server APIs
only: http://wiki.ros.org/ROS/Master_API, http://wiki.ros.org/ROS/Parameter%20Server%20API.
"""

import contextlib
import http.client
import threading
import xmlrpc.client
from typing import (
    Any,
    Dict,
    Iterable,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
    Union,
)

from nodekit.parameters.no_value import MISSING, UNREADABLE

_SUCCESS = 1
#: Most keys in one of several requests.
_TOGETHER = 500

#: What a request raises where the master does not answer or is not one.
UNREACHABLE = (OSError, http.client.HTTPException, xmlrpc.client.Error)


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
    """HTTP that gives up after a time, and does without compression."""

    # Which takes the master several times as long as the rest of its answer.
    accept_gzip_encoding = False

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout
        self._latest = b""
        self._parsed: Any = None

    def make_connection(
        self, host: Union[str, Tuple[str, Dict[str, str]]]
    ) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection

    def parse_response(self, response: Any) -> Any:
        """Return what an answer says, without parsing the same text again.

        The usual answer to the question for changes is that there are none.
        """
        text = response.read()
        if text != self._latest:
            parser, unmarshaller = self.getparser()
            parser.feed(text)
            parser.close()
            self._latest, self._parsed = text, unmarshaller.close()
        return self._parsed


class _Advance:
    """What has been read in advance, and what is still to be written.

    :param readings: of all keys, at least one
    """

    def __init__(self, readings: Sequence[Reading]) -> None:
        self._last = readings[-1]
        self._values = {key: value for part in readings for key, value in part.values.items()}
        self.writes: Dict[str, Any] = {}

    def read(self, keys: Sequence[str]) -> Reading:
        """Return keys as they were."""
        return self._last._replace(values={key: self._values[key] for key in keys})


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
        self._advance: Optional[_Advance] = None

    def _connect(self, timeout: float) -> xmlrpc.client.ServerProxy:
        return xmlrpc.client.ServerProxy(self._master_uri, transport=_Transport(timeout))

    def read(self, keys: Sequence[str]) -> Reading:
        """Read keys in one request, past every cache.

        :param keys: global names of parameters or namespaces
        :returns: the values, and whether the master knows this node; below a
            namespace, UNREADABLE stands for what the master cannot send
        :raises UNREACHABLE: if the master does not answer
        """
        if self._advance is not None:
            return self._advance.read(keys)
        calls: List[Tuple[Any, ...]] = [("lookupNode", self._node_name), ("getPid",)]
        try:
            node, pid, *answers = self._request(calls + [("getParam", key) for key in keys])
        except xmlrpc.client.Fault:  # one value that cannot be sent hides all others
            node, pid = self._request(calls)
            values = {key: self._read_alone(key) for key in keys}
        else:
            values = {key: _value(answer) for key, answer in zip(keys, answers)}
        return Reading(values, node[0] == _SUCCESS, pid[2])

    def _read_alone(self, key: str) -> Any:
        """Read one key; where that fails, all that is below it one by one."""
        try:
            return _value(self._request([("getParam", key)])[0])
        except xmlrpc.client.Fault:
            tree: Dict[str, Any] = {}
            for name in self._request([("getParamNames",)])[0][2]:
                if name.startswith(key + "/"):
                    *branches, leaf = name[len(key) + 1 :].split("/")
                    branch = tree
                    for part in branches:
                        branch = branch.setdefault(part, {})
                    branch[leaf] = self._read_alone(name)
            return tree or UNREADABLE

    def write(self, values: Mapping[str, Any]) -> None:
        """Set keys in one request. The master does not notify the writing node.

        :param values: raw value by global name
        :raises UNREACHABLE: if the master does not answer
        """
        if self._advance is not None:
            self._advance.writes.update(values)
            return
        self._request([("setParam", key, value) for key, value in values.items()])

    def subscribe(self, keys: Iterable[str]) -> None:
        """Have the master send changes of these keys, and below them, to the node.

        :param keys: global names of parameters or namespaces
        :raises UNREACHABLE: if the master does not answer
        """
        self._request([("subscribeParam", self._node_uri, key) for key in keys])

    @contextlib.contextmanager
    def in_advance(self, keys: Sequence[str]) -> Iterator[None]:
        """Read keys now, and put off what is written meanwhile until the end.

        For the start of something with thousands of namespaces, which would take as many requests.
        Meanwhile these keys alone can be read.

        :param keys: global names of all that will be read
        :raises UNREACHABLE: if the master does not answer
        """
        readings = [self.read(part) for part in parts(keys)]
        self._advance = advance = _Advance(readings)
        try:
            yield
        finally:
            self._advance = None
        for part in parts(list(advance.writes)):
            self.write({key: advance.writes[key] for key in part})

    def unsubscribe(self, keys: Iterable[str], timeout: float = 0.5) -> None:
        """Take subscriptions back, over a connection of its own.

        Meant for shut-down, which may have interrupted the very thread that
        holds the lock of the shared connection.

        :param keys: global names, as they were subscribed
        :param timeout: longest wait for an answer, s
        :raises UNREACHABLE: if the master does not answer
        """
        with self._connect(timeout) as master:
            calls = xmlrpc.client.MultiCall(master)
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


def parts(keys: Sequence[str]) -> List[Sequence[str]]:
    """Divide keys among requests, so that the master's other clients are served between two.

    :param keys: any number of them
    :returns: parts in the same order, at least one
    """
    return [keys[i : i + _TOGETHER] for i in range(0, len(keys), _TOGETHER)] or [keys]


def _value(answer: Tuple[int, str, Any]) -> Any:
    code, _, value = answer
    return value if code == _SUCCESS else MISSING
