"""Client of the ROS master for tests, not a node: queries and kills nodes, and sets parameters."""

import os
from typing import Any, Dict, Set
from xmlrpc.client import ServerProxy

from nodekit.deprecated import OldMethod
from nodekit.master import MISSING, MasterClient, Registrations
from nodekit.testing.waiting import TIMEOUT_S, wait_until


class Graph:
    """Nodes, topics and parameters added to the graph since the creation of this object.

    Nodes that existed before (rosout, the test itself) are excluded. The ``wait_for_…`` methods
    return as soon as the state is reached, and raise an AssertionError with the actual state if it
    is not reached in time.
    """

    def __init__(self, caller_id: str = "/graph_observer") -> None:
        self._caller_id = caller_id
        self._master = MasterClient(caller_id, timeout=TIMEOUT_S)
        self._earlier: Set[str] = set()
        self._earlier = self.nodes()

    def nodes(self, under: str = "/") -> Set[str]:
        """Return the names of all nodes that publish, subscribe or serve.

        :param under: prefix of the names, for a part of the graph
        """
        registered = {
            node for part in self._master.system_state() for _, nodes in part for node in nodes
        }
        return {node for node in registered - self._earlier if node.startswith(under)}

    def publishers(self, topic: str) -> Set[str]:
        """Return the names of the nodes that publish a topic."""
        return self._registered(self._master.system_state().publishers, topic)

    def subscribers(self, topic: str) -> Set[str]:
        """Return the names of the nodes that subscribe to a topic."""
        return self._registered(self._master.system_state().subscribers, topic)

    def topics(self) -> Dict[str, str]:
        """Return the type of every topic that was ever published."""
        return self._master.topic_types()

    def parameter(self, name: str) -> Any:
        """Return a parameter's value, or a namespace of them as a dict.

        :raises KeyError: if it is not set
        """
        value = self._master.read([name]).values[name]
        if value is MISSING:
            raise KeyError(name)
        return value

    def parameters(self) -> Set[str]:
        """Return the names of all parameters."""
        return set(self._master.request([("getParamNames",)])[0][2])

    def set_parameter(self, name: str, value: Any) -> None:
        """Set a parameter."""
        self._master.write({name: value})

    def delete_parameter(self, name: str) -> None:
        """Delete a parameter, if it is set."""
        self._master.request([("deleteParam", name)])

    def pid(self, node: str) -> int:
        """Return the process id of a running node."""
        answer: Any = self._node(node).getPid(self._caller_id)
        return int(answer[2])

    def environment(self, node: str) -> Dict[str, str]:
        """Return the environment variables that a running node was started with."""
        with open(f"/proc/{self.pid(node)}/environ") as variables:
            pairs = (text.partition("=") for text in variables.read().split("\0") if text)
            return {name: value for name, _, value in pairs}

    def connected_subscribers(self, node: str, topic: str) -> Set[str]:
        """Return the names of the nodes connected to a topic of a running node."""
        connections: Any = self._node(node).getBusInfo(self._caller_id)
        return {entry[1] for entry in connections[2] if entry[2] == "o" and entry[4] == topic}

    hearers = OldMethod("connected_subscribers")

    def niceness(self, node: str) -> int:
        """Return the niceness of a running node; the higher, the lower its priority."""
        return os.getpriority(os.PRIO_PROCESS, self.pid(node))

    def kill(self, node: str) -> None:
        """End a node the way rosnode kill does."""
        try:
            self._node(node).shutdown(self._caller_id, "ended by a test")
        except ConnectionError:
            pass  # the node ended before its response

    def wait_for_nodes(self, *names: str, under: str = "/") -> None:
        """Wait until exactly these nodes exist, and have finished init_node.

        :param names: names of the nodes
        :param under: prefix of the names to consider
        """
        wait_until(
            lambda: self.nodes(under) == set(names) and self.initialised(*names),
            lambda: f"nodes are {sorted(self.nodes(under))}, not {sorted(names)}",
        )

    def initialised(self, *names: str) -> bool:
        """Return whether all these nodes have finished init_node.

        Its last step is to offer the service that sets the log level.
        """
        services = {service for service, _ in self._master.system_state().services}
        return all(name + "/set_logger_level" in services for name in names)

    def wait_until_heard(self, node: str, topic: str, *subscribers: str) -> None:
        """Wait until all these nodes are connected to a topic of a running node.

        rospy's subscriber reports a connection when it only begins to connect.

        :param node: name of the publishing node
        :param topic: global name of the topic
        :param subscribers: names of the subscribing nodes
        """
        wait_until(
            lambda: self.connected_subscribers(node, topic).issuperset(subscribers),
            lambda: f"subscribers of {topic}: {sorted(self.connected_subscribers(node, topic))}",
        )

    def wait_for_parameters(self, namespace: str, expected: Dict[str, Any]) -> None:
        """Wait until some parameters have these values.

        :param namespace: namespace of the parameters; a node's name for its private parameters
        :param expected: values by name
        """

        def found() -> Dict[str, Any]:
            paths = {name: f"{namespace}/{name}" for name in expected}
            present = self.parameters()
            return {
                name: self.parameter(path)
                for name, path in paths.items()
                if any((other + "/").startswith(path + "/") for other in present)
            }

        wait_until(
            lambda: found() == expected,
            lambda: f"{namespace} has {found()}, not {expected}",
        )

    def wait_for_publishers(self, topic: str, *names: str) -> None:
        """Wait until exactly these nodes publish a topic."""
        expected = set(names)
        wait_until(
            lambda: self.publishers(topic) == expected,
            lambda: (
                f"{topic} is published by {sorted(self.publishers(topic))}, not {sorted(expected)}"
            ),
        )

    def wait_for_subscribers(self, topic: str, *names: str) -> None:
        """Wait until exactly these nodes subscribe to a topic."""
        expected = set(names)
        wait_until(
            lambda: self.subscribers(topic) == expected,
            lambda: (
                f"{topic} is subscribed to by {sorted(self.subscribers(topic))}, not "
                f"{sorted(expected)}"
            ),
        )

    def _registered(self, registrations: Registrations, topic: str) -> Set[str]:
        return set(dict(registrations).get(topic, [])) - self._earlier

    def _node(self, name: str) -> ServerProxy:
        uri = self._master.lookup_node(name)
        if uri is None:
            raise LookupError(f"the master does not know {name}")
        return ServerProxy(uri)
