"""Client of the ROS master and its parameter server, with time-outs and batches.

rospy's own client waits forever on a hung master, keeps stale values
after a cached read, and takes one round trip for each key. This one batches any number of
calls. It uses the Master and Parameter Server APIs only:
http://wiki.ros.org/ROS/Master_API, http://wiki.ros.org/ROS/Parameter%20Server%20API.
"""

import contextlib
import functools
import http.client
import re
import threading
import xmlrpc.client
from typing import (
    Any,
    Collection,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Tuple,
)

import rosgraph

from nodekit.argument_checks import check_timeout

# Public here: values of a Reading.
from nodekit.parameters.parameter_types import MISSING as MISSING
from nodekit.parameters.parameter_types import UNREADABLE as UNREADABLE

#: Status in a reply to getBusInfo of a node whose connections another node has, such as a bridge.
CONNECTED_ELSEWHERE = "another node has the connections of this one"
_SUCCESS = 1
#: Most calls in one request; the master serves other clients between two requests.
_TOGETHER = 500
#: Number of cached replies: each second there is one of values and one of services.
_CACHED_REPLIES = 2
#: Errors of a request; UnicodeError for an invalid host name.
_FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error, UnicodeError)

#: One call: the name of a method of the master, and its arguments without the caller's name.
Call = Tuple[Any, ...]
#: Names of topics or services, each with the names of its nodes.
Registrations = List[Tuple[str, List[str]]]


class MasterUnreachable(ConnectionError):
    """Error of a master that does not reply, or of a server that is not a master."""


class _Fault(MasterUnreachable):
    """Error reply of the master, as for a value that XML-RPC cannot carry."""


class Reading(NamedTuple):
    """Values of the parameter server at one moment.

    :param values: raw value by key, MISSING if the key is not set
    :param knows_node: whether the master knows the node; not after a restart
    :param master_pid: process id of the master, which also changes in a restart
    """

    values: Dict[str, Any]
    knows_node: bool
    master_pid: int


class SystemState(NamedTuple):
    """Publishers, subscribers and service providers on the graph."""

    publishers: Registrations
    subscribers: Registrations
    services: Registrations


class TimeoutTransport(xmlrpc.client.Transport):
    """HTTP transport with a time-out, without compression.

    :param timeout: longest wait for a connection, and for each part of a reply [s]
    """

    # Compression takes the master several times as long as the rest of its reply.
    accept_gzip_encoding = False

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout
        # Most replies are equal to the previous one, and need not be parsed again.
        self._parse = functools.lru_cache(_CACHED_REPLIES)(_parse)

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection

    def parse_response(self, response: Any) -> Any:
        """Return the parsed reply."""
        return self._parse(response.read())


def _parse(text: bytes) -> Any:
    try:
        parser, unmarshaller = xmlrpc.client.getparser()
        parser.feed(text)
        parser.close()
        return unmarshaller.close()
    except xmlrpc.client.Fault:
        raise
    except Exception as error:  # of any kind: the parser does not check its input
        raise xmlrpc.client.ResponseError(f"not XML-RPC ({error})") from None


def scheme_hint(uri: str) -> str:
    """Return a clause with the corrected URI if only ``http://`` is missing, or an empty text.

    :param uri: URI of the master, as given
    """
    is_address = re.fullmatch(r"[A-Za-z0-9_.-]+:[0-9]{1,5}/?", uri)
    return f"; it needs http:// in front: set it to http://{uri}" if is_address else ""


class MasterClient:
    """Client of the master for one node; thread-safe.

    All methods raise :class:`MasterUnreachable` if the master does not reply.

    :param node_name: name of the node, global
    :param node_uri: XML-RPC URI of the node, where the master sends updates
    :param timeout: longest wait for a reply [s]
    :param master_uri: URI of the master; by default, that of this process
    :raises MasterUnreachable: if the URI is not an HTTP URI
    :raises ValueError: if the time-out is invalid
    """

    def __init__(
        self, node_name: str, node_uri: str = "", timeout: float = 5.0, master_uri: str = ""
    ) -> None:
        check_timeout(timeout)
        self._uri = master_uri or rosgraph.get_master_uri()
        self._node_name = node_name
        self._node_uri = node_uri
        self._lock = threading.Lock()
        try:
            self._proxy = xmlrpc.client.ServerProxy(self._uri, transport=TimeoutTransport(timeout))
        except OSError as error:
            raise self._unreachable(f"{error}{scheme_hint(self._uri)}") from None

    def __enter__(self) -> "MasterClient":
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection; another request opens it again."""
        self._proxy("close")()

    def request(self, calls: List[Call]) -> List[Any]:
        """Send calls to the master, up to 500 in one request.

        :param calls: any number of calls
        :returns: the replies, each a status, a text and a value
        """
        answers: List[Any] = []
        for start in range(0, len(calls), _TOGETHER):
            answers += self._request_part(calls[start : start + _TOGETHER])
        return answers

    def _request_part(self, calls: List[Call]) -> List[Any]:
        batch = [
            {"methodName": method, "params": [self._node_name, *arguments]}
            for method, *arguments in calls
        ]
        try:
            with self._lock:
                results: Any = self._proxy.system.multicall(batch)
        except xmlrpc.client.Fault as error:
            raise _Fault(str(self._unreachable(error))) from None
        except _FAILURES as error:
            raise self._unreachable(error) from None
        with self._checked_format(results):
            if len(results) != len(calls):
                raise ValueError
            return [self._checked(result) for result in results]

    def _checked(self, result: Any) -> Any:
        """Return the reply to one call: the only item of a list, or a dict if the call failed."""
        if isinstance(result, dict):
            raise _Fault(str(self._unreachable(result.get("faultString", result))))
        ((code, text, value),) = result
        return code, text, value

    @contextlib.contextmanager
    def _checked_format(self, answer: Any) -> Iterator[None]:
        """Raise MasterUnreachable for a reply that a master would not send."""
        try:
            yield
        except (TypeError, ValueError):
            raise self._unreachable(f"not a reply of a master: {answer!r:.80}") from None

    def _unreachable(self, why: object) -> MasterUnreachable:
        return MasterUnreachable(f"{self._uri}: {why}")

    def read(self, keys: Collection[str]) -> Reading:
        """Read keys of the parameter server, without a cache.

        :param keys: global names of parameters or namespaces
        :returns: the values, and whether the master knows this node; in a namespace, UNREADABLE
            replaces values that the master cannot send
        """
        calls: List[Call] = [("lookupNode", self._node_name), ("getPid",)]
        try:
            node, pid, *answers = self.request(calls + [("getParam", key) for key in keys])
        except _Fault:  # one unsendable value hides all others
            node, pid = self.request(calls)
            values = {key: self._read_alone(key) for key in keys}
        else:
            values = {key: _value(answer) for key, answer in zip(keys, answers)}
        return Reading(values, node[0] == _SUCCESS, pid[2])

    def _read_alone(self, key: str) -> Any:
        """Read one key; if that fails, read the keys below it one by one."""
        try:
            return _value(self.request([("getParam", key)])[0])
        except _Fault:
            tree: Dict[str, Any] = {}
            for name in self.request([("getParamNames",)])[0][2]:
                if name.startswith(key + "/"):
                    *branches, leaf = name[len(key) + 1 :].split("/")
                    branch = tree
                    for part in branches:
                        branch = branch.setdefault(part, {})
                    branch[leaf] = self._read_alone(name)
            return tree or UNREADABLE

    def write(self, values: Mapping[str, Any]) -> None:
        """Set keys of the parameter server. The master does not notify the writing node.

        :param values: raw value by global name
        """
        self.request([("setParam", key, value) for key, value in values.items()])

    def subscribe(self, keys: Collection[str]) -> None:
        """Subscribe the node to changes of keys, and of keys below them.

        :param keys: global names of parameters or namespaces
        """
        self.request([("subscribeParam", self._node_uri, key) for key in keys])

    def unsubscribe(self, keys: Collection[str], timeout: float = 0.5) -> None:
        """Unsubscribe, over a separate connection.

        Meant for shutdown, when the shared connection may be waiting for a reply.

        :param keys: global names, as they were subscribed
        :param timeout: longest wait for a reply [s]
        """
        with MasterClient(self._node_name, self._node_uri, timeout, self._uri) as client:
            client.request([("unsubscribeParam", self._node_uri, key) for key in keys])

    def system_state(self) -> SystemState:
        """Return the publishers, subscribers and service providers on the graph."""
        state = self.request([("getSystemState",)])[0][2]
        with self._checked_format(state):
            return SystemState(*([(name, nodes) for name, nodes in part] for part in state))

    def topic_types(self) -> Dict[str, str]:
        """Return the type of each topic."""
        types = self.request([("getTopicTypes",)])[0][2]
        with self._checked_format(types):
            return {topic: kind for topic, kind in types}

    def lookup_node(self, name: str) -> Optional[str]:
        """Return the URI of a node, None for an unknown node."""
        code, _, uri = self.request([("lookupNode", name)])[0]
        return str(uri) if code == _SUCCESS else None

    def lookup_service(self, name: str) -> Optional[str]:
        """Return the URI of a service, None for an unknown service."""
        code, _, uri = self.request([("lookupService", name)])[0]
        return str(uri) if code == _SUCCESS else None

    def namespaces_offering(self, service: str, below: str = "/") -> List[str]:
        """Return the namespaces in which a service is offered.

        :param service: base name of the service
        :param below: global name; only namespaces at or below it are listed
        :returns: global names, sorted
        """
        prefix, suffix = below.rstrip("/") + "/", "/" + service
        names = [name for name, _ in self.system_state().services if name.endswith(suffix)]
        found = [name[: -len(suffix)] for name in names]
        return sorted(owner for owner in found if (owner + "/").startswith(prefix))


def _value(answer: Tuple[int, str, Any]) -> Any:
    code, _, value = answer
    return value if code == _SUCCESS else MISSING
