"""Registrations of ROS 2 nodes with the ROS 1 master.

The master lists only nodes with registrations. Each ROS 2 node is registered as a subscriber of
/parameter_events, which it also is in ROS 2, and with its publishers, subscriptions and services. A
subscriber asks each publisher's address for the topic; these nodes refuse, because the bridge sends
the topic. A service has a single node in ROS 1, here the ROS 2 node; its calls go to the bridge.

The registrations have an address of their own, not the bridge's: if a ROS 1 node takes the name of
a ROS 2 node, the master shuts down the node at the registered address.
"""

import contextlib
import os
import socket
import threading
import urllib.parse
from typing import AbstractSet, Any, Dict, List, Mapping, NamedTuple, Set

import rosgraph
import rosgraph.xmlrpc

from nodekit.master import CONNECTED_ELSEWHERE, Call, MasterClient
from ros2_bridge.ros1.graph import Ros1Graph

#: Timeout for the address, for the master and for another node [s].
_TIMEOUT_S = 1.0


class Registration(NamedTuple):
    """A registration of a node with the master.

    :param kind: Publisher, Subscriber or Service
    :param name: of the topic or service
    :param type: of the topic
    """

    kind: str
    name: str
    type: str = ""


#: Registration of every ROS 2 node.
_EVENTS = Registration("Subscriber", "/parameter_events", "rcl_interfaces/ParameterEvent")


class NodeRegistrar:
    """Registrations of ROS 2 nodes with the master.

    One thread updates the registrations; another may close the registrar meanwhile.

    :param bridge: name of the bridge, which offers services for them
    """

    def __init__(self, bridge: str) -> None:
        self._bridge = bridge
        self._registered: Dict[str, Set[Registration]] = {}
        #: Nodes of another running bridge, for example to another domain.
        self._others: Set[str] = set()
        self._calls_to = ""
        #: Held during calls of the master, which stop as soon as the registrar is closed.
        self._lock, self._is_closed = threading.Lock(), False
        self._address = _SlaveApi()
        self._server = rosgraph.xmlrpc.XmlRpcNode(rpc_handler=self._address)
        self._server.start()

    @property
    def names(self) -> Set[str]:
        """Registered names: of ROS 2 nodes, not of ROS 1 nodes."""
        return set(self._registered)

    def remove_stale(self, graph: Ros1Graph) -> bool:
        """Unregister the nodes of a killed bridge, which the master still lists.

        :param graph: of ROS 1
        :returns: whether there were any
        :raises MasterUnreachable: if the master does not answer
        """
        listed = graph.subscribers.get(_EVENTS.name, set())
        self._others &= listed
        found = False
        for name in listed - self._others:
            if _refuses(self._address_of(name)):
                with self._lock:
                    if self._is_closed:
                        return found
                    self._change(name, {_EVENTS})  # the master drops all of the old address
                    self._forget(name)
                found = True
            else:
                self._others.add(name)
        return found

    def register(
        self, nodes: Mapping[str, AbstractSet[Registration]], in_ros1: Set[str], is_restarted: bool
    ) -> None:
        """Register new nodes with their entries, and unregister those that have disappeared.

        :param nodes: registrations of each ROS 2 node, by name
        :param in_ros1: names of the ROS 1 nodes
        :param is_restarted: whether the master was restarted, and has lost its state
        :raises MasterUnreachable: if it does not answer
        """
        with self._lock:
            self._drop_forgotten(is_restarted)
            for name in (*self.names.difference(nodes), *nodes):
                if self._is_closed:
                    return
                if name not in nodes:
                    self._forget(name)
                # Registering the name of a new ROS 1 node would shut that node down.
                elif name in self._registered or not (name in in_ros1 or self._address_of(name)):
                    self._change(name, {_EVENTS, *nodes[name]})

    def _drop_forgotten(self, is_restarted: bool) -> None:
        """Drop registrations that the master no longer has."""
        if is_restarted:
            self._registered = {}
        if self._address.is_taken.is_set():
            self._address.is_taken.clear()
            for name in self.names:
                if self._address_of(name) != self._address.uri:
                    del self._registered[name]

    def _forget(self, name: str) -> None:
        self._change(name, set())
        del self._registered[name]

    def _change(self, name: str, wanted: Set[Registration]) -> None:
        """Register new entries of a node, and unregister old ones."""
        known = self._registered.setdefault(name, set())
        if known == wanted:
            return
        uri, calls_to = self._address.uri, self._call_address()
        calls: List[Call] = []
        for kind, its, _ in known - wanted:
            calls.append((f"unregister{kind}", its, calls_to if kind == "Service" else uri))
        for kind, its, its_type in wanted - known:
            calls.append((f"register{kind}", its, its_type or calls_to, uri))
        with self._master(name) as master:
            master.request(calls)
        self._registered[name] = wanted

    def close(self) -> None:
        """Unregister all nodes, if the master answers, and register no more."""
        self._is_closed = True
        if self._lock.acquire(timeout=_TIMEOUT_S / 2):
            try:
                with contextlib.suppress(ConnectionError):
                    for name in self.names:
                        self._forget(name)
            finally:
                self._lock.release()
        self._server.shutdown("")

    def _address_of(self, name: str) -> str:
        """Return the address of a node; empty if it has none."""
        with self._master(name) as master:
            return master.lookup_node(name) or ""

    def _call_address(self) -> str:
        """Return the address for calls of the bridge's services, the same for all."""
        if not self._calls_to:
            with self._master(self._bridge) as master:
                self._calls_to = master.lookup_service(f"{self._bridge}/get_loggers") or ""
        return self._calls_to

    def _master(self, name: str) -> MasterClient:
        return MasterClient(name, self._address.uri, _TIMEOUT_S)


def _refuses(address: str) -> bool:
    """Return whether the address of a node refuses connections."""
    parts = urllib.parse.urlsplit(address)
    try:
        with socket.create_connection((parts.hostname or "", parts.port or 0), _TIMEOUT_S):
            return False
    except ConnectionRefusedError:
        return True
    except (OSError, ValueError):
        return False


class _SlaveApi(rosgraph.xmlrpc.XmlRpcHandler):
    """XML-RPC handler that answers ROS 1's requests to all these nodes.

    :ivar is_taken: set when the master has shut down a node because another took its name
    """

    def __init__(self) -> None:
        self.is_taken, self._is_ready = threading.Event(), threading.Event()
        self._uri = ""

    def _ready(self, uri: str) -> None:
        self._uri = uri
        self._is_ready.set()

    @property
    def uri(self) -> str:
        """Address of these nodes."""
        if not self._is_ready.wait(_TIMEOUT_S):
            raise ConnectionError("the nodes of ROS 2 have no address in ROS 1")
        return self._uri

    def shutdown(self, _caller: str, _why: str = "") -> List[Any]:
        """Note that a name may have been taken; ``rosnode kill`` sends the same request."""
        self.is_taken.set()
        return [1, "", 0]

    def getPid(self, _caller: str) -> List[Any]:  # noqa: N802  (named by ROS 1)
        """Answer ``rosnode ping``."""
        return [1, "", os.getpid()]

    def getBusInfo(self, _caller: str) -> List[Any]:  # noqa: N802
        """Answer ``rosnode info``: these nodes have no connections, as the bridge has them."""
        return [1, CONNECTED_ELSEWHERE, []]

    def getSubscriptions(self, _caller: str) -> List[Any]:  # noqa: N802
        """Answer ``rosrun nodekit doctor``: the bridge subscribes for these nodes."""
        return [1, "", []]

    def publisherUpdate(self, *_: Any) -> List[Any]:  # noqa: N802
        """Ignore the publishers in ROS 1: the bridge finds them itself."""
        return [1, "", 0]

    def requestTopic(self, *_: Any) -> List[Any]:  # noqa: N802
        """Refuse a subscriber: the bridge sends it the topic."""
        return [0, "the bridge sends this topic", 0]
