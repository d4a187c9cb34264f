"""The names of ROS 2's nodes in ROS 1's list of nodes.

The master lists whoever has registered something. Each node of ROS 2 is registered as a subscriber
of /parameter_events, which it is in ROS 2 too; the master's notifications are ignored. If they were
registered as publishers, subscribers would connect to the bridge twice.

They do not have the bridge's own address: the master ends whoever is at the address of a name that
another node takes, and a node of ROS 1 may have the name of one of ROS 2.
"""

import contextlib
import os
import threading
from typing import Any, List, Set

import rosgraph
import rosgraph.xmlrpc

from nodekit.master import MasterClient

_TOPIC, _TYPE = "/parameter_events", "rcl_interfaces/ParameterEvent"
#: Longest wait for the address, and for the master, s.
_TIMEOUT_S = 1.0


class NamesInRos1:
    """Registers names with the master, and takes them back.

    :ivar names: those that are registered: nodes of ROS 2, not of ROS 1
    """

    def __init__(self) -> None:
        self.names: Set[str] = set()
        self._address = _Address()
        self._server = rosgraph.xmlrpc.XmlRpcNode(rpc_handler=self._address)
        self._server.start()

    def register(self, nodes: Set[str], is_restarted: bool) -> None:
        """Register the nodes that have come, and take back those that have gone.

        :param nodes: names of the nodes of ROS 2
        :param is_restarted: whether the master has forgotten all
        :raises MasterUnreachable: if it does not answer
        """
        if is_restarted:
            self.names = set()
        if self._address.is_taken.is_set():
            self._address.is_taken.clear()
            self.names = {name for name in self.names if self._is_at(name, self._address.uri)}
        for name in self.names - nodes:
            self._request(name, "unregisterSubscriber", _TOPIC, self._address.uri)
        self.names &= nodes
        for name in nodes - self.names:
            if self._is_at(name, ""):  # nobody of ROS 1 has come meanwhile, whom that would end
                self.names.add(name)
                self._request(name, "registerSubscriber", _TOPIC, _TYPE, self._address.uri)

    def close(self) -> None:
        """Take all of them back, if the master answers."""
        with contextlib.suppress(ConnectionError):
            self.register(set(), False)
        self._server.shutdown("")

    def _is_at(self, name: str, uri: str) -> bool:
        """Tell whether the node of a name has an address; an empty one: whether there is none."""
        return str(self._request(name, "lookupNode", name)[2] or "") == uri

    def _request(self, name: str, *call: str) -> Any:
        with MasterClient(name, self._address.uri, _TIMEOUT_S) as client:
            return client.request([call])[0]


class _Address(rosgraph.xmlrpc.XmlRpcHandler):
    """Answers for all these nodes the requests that a node of ROS 1 gets.

    :ivar is_taken: set once the master has ended one of them, as another has its name
    """

    def __init__(self) -> None:
        self.is_taken, self._is_ready = threading.Event(), threading.Event()
        self._uri = ""

    def _ready(self, uri: str) -> None:
        self._uri = uri
        self._is_ready.set()

    @property
    def uri(self) -> str:
        """Where it is."""
        if not self._is_ready.wait(_TIMEOUT_S):
            raise ConnectionError("the nodes of ROS 2 have no address in ROS 1")
        return self._uri

    def shutdown(self, _caller: str, _why: str = "") -> List[Any]:
        """Remember that a name may be another's now; ``rosnode kill`` asks for this as well."""
        self.is_taken.set()
        return [1, "", 0]

    def getPid(self, _caller: str) -> List[Any]:  # noqa: N802  (named by ROS 1)
        """Answer ``rosnode ping``."""
        return [1, "", os.getpid()]

    def getBusInfo(self, _caller: str) -> List[Any]:  # noqa: N802
        """Answer ``rosnode info``: there are no connections."""
        return [1, "", []]

    def publisherUpdate(self, *_: Any) -> List[Any]:  # noqa: N802
        """Accept who publishes /parameter_events in ROS 1, which is of no use."""
        return [1, "", 0]
