"""Rig for tests of live parameters: a node to test, and a spy on the master."""

import json
import os
import unittest
from typing import Any, Dict, List, Optional

from nodekit.testing.processes import Process, Server
from nodekit.testing.waiting import wait_until

HELPERS = os.path.dirname(os.path.abspath(__file__))


class ParameterNode(Process):
    """A parameter_node.py.

    :param name: its global name
    :param environment: variables to set on top of the test's own
    """

    def __init__(self, name: str, environment: Optional[Dict[str, str]] = None) -> None:
        namespace, _, base = name.rpartition("/")
        self.name = name
        super().__init__(
            os.path.join(HELPERS, "parameter_node.py"),
            ["__name:=" + base],
            {"ROS_NAMESPACE": namespace or "/", **(environment or {})},
        )

    @property
    def reports(self) -> List[Dict[str, Any]]:
        """Values that the node has printed, oldest first."""
        return [json.loads(line) for line in self.lines if line.startswith("{")]

    @property
    def values(self) -> Dict[str, Any]:
        """The values in force."""
        return dict(self.reports[-1]["values"])

    @property
    def changes(self) -> int:
        """Number of calls of the node's callback."""
        return int(self.reports[-1]["changes"])

    def wait_for(self, **values: Any) -> None:
        """Wait until these values are in force."""
        wait_until(
            lambda: self.reports and {**self.values, **values} == self.values,
            lambda: f"{values} in {self.reports[-1:]}; log: {self.logged()[-5:]}",
        )

    def send(self, **command: Any) -> None:
        """Have it obey a command, see parameter_node.py."""
        self.popen.stdin.write(json.dumps(command) + "\n")


class Spy(Process):
    """A parameter_spy.py.

    :param keys: keys of its notifications
    """

    def __init__(self, *keys: str) -> None:
        super().__init__(os.path.join(HELPERS, "parameter_spy.py"), keys)
        wait_until(lambda: self.lines, lambda: f"spy: {self.error_lines}")

    @property
    def updates(self) -> List[List[Any]]:
        """Key and value of each write, oldest first."""
        return [json.loads(line) for line in self.lines[1:]]


class ParameterCase(unittest.TestCase):
    """A test that starts processes and knows what must always hold of a node."""

    def launch_node(self, name: str, **environment: str) -> ParameterNode:
        """Start a node that is killed at the end of the test."""
        node = ParameterNode(name, environment)
        self.addCleanup(node.end)
        return node

    def start_node(self, name: str, **environment: str) -> ParameterNode:
        """Start a node as above and wait for its first values."""
        node = self.launch_node(name, **environment)
        wait_until(lambda: node.reports, lambda: f"start of {name}: {node.logged()}")
        return node

    def assert_truth(self, node: ParameterNode, server: Server) -> None:
        """Wait until the server has exactly the node's values."""

        def told() -> Dict[str, Any]:
            held = server.get(node.name)
            return {k: v for k, v in held.items() if k in node.values} if held else {}

        wait_until(
            lambda: told() == node.values,
            lambda: f"the server holds {told()}, in force is {node.values}",
        )
