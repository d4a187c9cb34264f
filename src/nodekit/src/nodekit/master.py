"""A client of the ROS master, and of its parameter server, with time-outs and batches.

rospy's own client waits for ever on a hung master, caches what it should not
after a cached read, and takes one round trip a key. This one puts any number of
questions into one request. It uses the Master and Parameter Server APIs only:
http://wiki.ros.org/ROS/Master_API, http://wiki.ros.org/ROS/Parameter%20Server%20API.
"""

import contextlib
import functools
import http.client
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

# What a reading holds is public as this module is.
from nodekit.parameters.parameter_types import MISSING as MISSING
from nodekit.parameters.parameter_types import UNREADABLE as UNREADABLE
from nodekit.validation import check_timeout

_SUCCESS = 1
#: Most calls in one of several requests: the master's other clients are served between two.
_TOGETHER = 500
#: How many answers are remembered: each second there is one of values and one of services.
_REMEMBERED = 2
#: What a request may raise; UnicodeError where the URI is no name of a host.
_FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error, UnicodeError)

#: One call: the name of a method of the master, and its arguments without the caller's name.
Call = Tuple[Any, ...]
#: Names of topics or services, each with the names of its nodes.
Registrations = List[Tuple[str, List[str]]]


class MasterUnreachable(ConnectionError):
    """The master does not answer, or what answers is none; the text says where and why."""


class _Fault(MasterUnreachable):
    """The master answers that it failed, as where it has to send what XML-RPC cannot carry."""


class Reading(NamedTuple):
    """What the parameter server held at one moment.

    :param values: raw value by key, MISSING where nothing is set
    :param knows_node: whether the master knows the node; it has forgotten it
        when it was restarted
    :param master_pid: process id of the master, another sign of a restart
    """

    values: Dict[str, Any]
    knows_node: bool
    master_pid: int


class SystemState(NamedTuple):
    """Who publishes, subscribes and serves what."""

    publishers: Registrations
    subscribers: Registrations
    services: Registrations


class _Transport(xmlrpc.client.Transport):
    """HTTP that gives up after a time, and does without compression."""

    # Which takes the master several times as long as the rest of its answer.
    accept_gzip_encoding = False

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout
        # The usual answer is that nothing has changed: the same text need not be parsed again.
        self._parse = functools.lru_cache(_REMEMBERED)(_parse)

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection

    def parse_response(self, response: Any) -> Any:
        """Return what an answer says."""
        return self._parse(response.read())


def _parse(text: bytes) -> Any:
    try:
        parser, unmarshaller = xmlrpc.client.getparser()
        parser.feed(text)
        parser.close()
        return unmarshaller.close()
    except xmlrpc.client.Fault:
        raise
    except Exception as error:  # of any kind: the parser takes for granted what it reads
        raise xmlrpc.client.ResponseError(f"not XML-RPC ({error})") from None


class MasterClient:
    """The master as one node sees it; methods may be called from any thread.

    All of them raise :class:`MasterUnreachable` if the master does not answer.

    :param node_name: name of the node, global
    :param node_uri: XML-RPC URI of the node, where the master sends updates
    :param timeout: longest wait for an answer, s
    :param master_uri: URI of the master; by default, of the one of this process
    :raises MasterUnreachable: if the URI is none of HTTP
    :raises ValueError: if the time-out is none
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
            self._proxy = xmlrpc.client.ServerProxy(self._uri, transport=_Transport(timeout))
        except OSError as error:
            raise self._unreachable(error) from None

    def __enter__(self) -> "MasterClient":
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection; another request would open it again."""
        self._proxy("close")()

    def request(self, calls: List[Call]) -> List[Any]:
        """Have the master answer calls, up to 500 in one request.

        :param calls: any number of them
        :returns: the answers, each a status, a text and a value
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
        with self._valid_reply(results):
            if len(results) != len(calls):
                raise ValueError
            return [self._checked(result) for result in results]

    def _checked(self, result: Any) -> Any:
        """Return the answer to one call: alone in a list, or a dict where the call failed."""
        if isinstance(result, dict):
            raise _Fault(str(self._unreachable(result.get("faultString", result))))
        ((code, text, value),) = result
        return code, text, value

    @contextlib.contextmanager
    def _valid_reply(self, answer: Any) -> Iterator[None]:
        """Take an answer without sense as that of something else than a master."""
        try:
            yield
        except (TypeError, ValueError):
            raise self._unreachable(f"not a reply of a master: {answer!r:.80}") from None

    def _unreachable(self, why: object) -> MasterUnreachable:
        return MasterUnreachable(f"{self._uri}: {why}")

    def read(self, keys: Collection[str]) -> Reading:
        """Read keys of the parameter server, past every cache.

        :param keys: global names of parameters or namespaces
        :returns: the values, and whether the master knows this node; below a
            namespace, UNREADABLE stands for what the master cannot send
        """
        calls: List[Call] = [("lookupNode", self._node_name), ("getPid",)]
        try:
            node, pid, *answers = self.request(calls + [("getParam", key) for key in keys])
        except _Fault:  # one value that cannot be sent hides all others
            node, pid = self.request(calls)
            values = {key: self._read_alone(key) for key in keys}
        else:
            values = {key: _value(answer) for key, answer in zip(keys, answers)}
        return Reading(values, node[0] == _SUCCESS, pid[2])

    def _read_alone(self, key: str) -> Any:
        """Read one key; where that fails, all that is below it one by one."""
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
        """Have the master send changes of these keys, and below them, to the node.

        :param keys: global names of parameters or namespaces
        """
        self.request([("subscribeParam", self._node_uri, key) for key in keys])

    def unsubscribe(self, keys: Collection[str], timeout: float = 0.5) -> None:
        """Take subscriptions back, over a connection of its own.

        Meant for shut-down, when the shared one may be waiting for an answer.

        :param keys: global names, as they were subscribed
        :param timeout: longest wait for an answer, s
        """
        with MasterClient(self._node_name, self._node_uri, timeout, self._uri) as client:
            client.request([("unsubscribeParam", self._node_uri, key) for key in keys])

    def system_state(self) -> SystemState:
        """Ask who publishes, subscribes and serves what."""
        state = self.request([("getSystemState",)])[0][2]
        with self._valid_reply(state):
            return SystemState(*([(name, nodes) for name, nodes in part] for part in state))

    def topic_types(self) -> Dict[str, str]:
        """Ask for the type of each topic."""
        types = self.request([("getTopicTypes",)])[0][2]
        with self._valid_reply(types):
            return {topic: kind for topic, kind in types}

    def lookup_node(self, name: str) -> Optional[str]:
        """Ask for the URI of a node, None where there is none."""
        code, _, uri = self.request([("lookupNode", name)])[0]
        return str(uri) if code == _SUCCESS else None

    def lookup_service(self, name: str) -> Optional[str]:
        """Ask for the URI of a service, None where there is none."""
        code, _, uri = self.request([("lookupService", name)])[0]
        return str(uri) if code == _SUCCESS else None

    def namespaces_offering(self, service: str, below: str = "/") -> List[str]:
        """List the namespaces where a service is offered.

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
