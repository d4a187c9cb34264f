#!/usr/bin/env python3
"""Each node of the workspace has the same values when started with a file dumped by rosparam.

This is an exercise of a course, for all nodes. They are found in their packages: each module in
``nodes`` calls ``run`` with a name and a class. This process hosts all of them, first in one
namespace, where as many of their parameters as possible are changed, then in another, where the
file is loaded before.

Because all nodes are running, their interfaces are compared with docs/compatibility.yaml. With the
variable ADD_PROMISES, new interfaces are added to it.
"""

import contextlib
import importlib.util
import os
import pathlib
import subprocess
import tempfile
import unittest
from typing import Any, Callable, Dict, Iterator, List, Tuple
from unittest import mock

import rospy
import yaml
from helpers import interfaces, promises
from std_srvs.srv import Trigger

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nodekit import Node, init_node
from nodekit.testing.processes import Server
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until
from nodekit_msgs.srv import SetParameters

SOURCES = pathlib.Path(__file__).resolve().parents[4] / "src"

#: Modules that are left out, and why.
LEFT_OUT = {
    "bot_controller_demo.nodes.teleop_keyboard": "starts in a terminal only",
    "lifecycle_manager.nodes.lifecycle_manager": "starts with nodes to manage only",
    "ros2_bridge.nodes.bridge": "takes ROS 2, which is not there",
    "serial_link.nodes.avr_board": "compiles a sketch, and ends its process where it cannot",
    "topic_scope.nodes.scope": "has options in place of parameters, and serves at a port",
}


def modules() -> List[str]:
    """Return the names of the modules of all nodes."""
    paths = (path.relative_to(path.parents[2]) for path in SOURCES.glob("*/src/*/nodes/*.py"))
    names = {".".join(path.with_suffix("").parts) for path in paths if path.stem != "__init__"}
    return sorted(names - set(LEFT_OUT))


def node_of(module: str) -> Tuple[str, Callable[[Node], object]]:
    """Return the name and the class of a module's node."""
    imported = importlib.import_module(module)
    with mock.patch.object(imported, "run") as run:
        imported.main()
    name, cls = run.call_args[0]
    return name, cls


def others(entry: Dict[str, Any]) -> Iterator[Any]:
    """Return other valid values of a parameter.

    :param entry: from the node's description
    """
    value = entry["value"]
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        step = entry.get("step") or 1
        yield from (value + step, value - step)
    elif isinstance(value, float):
        yield from (value / 2.0, value + 0.001)
        yield from (entry[limit] for limit in ("maximum", "minimum") if limit in entry)
    elif isinstance(value, list):
        yield from (value + value[:1], value[:-1], value[::-1], ["/off"])
    else:
        yield from (choice for choice in entry.get("choices", ()) if choice != value)
        yield from ("off", value + "_2", value + ": #1 'é'")


class Settings:
    """Parameters of a running node.

    :param node: its global name
    :param registered: its registrations
    """

    def __init__(self, node: str, registered: interfaces.Registrations) -> None:
        self._node = node
        self._registered = registered
        services = Server().services()
        if f"{node}/change_state" in services:  # a managed node has parameters once configured
            self._call("change_state", ChangeState, Transition(label="configure"))
            services = Server().services()
        #: Descriptions by the nodes; empty for a node without parameters.
        self.described: List[Dict[str, Any]] = []
        if f"{node}/describe" in services:
            self.described = yaml.safe_load(self._call("describe", Trigger).message)

    def _call(self, service: str, kind: Any, *arguments: Any) -> Any:
        return rospy.ServiceProxy(f"{self._node}/{service}", kind)(*arguments)

    def in_force(self) -> Dict[str, Any]:
        """Return the values that the node uses."""
        if not self.described:
            return {}
        values: Dict[str, Any] = yaml.safe_load(self._call("change", SetParameters, "{}").values)
        return values

    def offered(self, promised: Dict[str, Any]) -> Dict[str, Any]:
        """Return the interfaces once they match the promises, or after a timeout.

        An action is served from a node's first step on, which may be later.
        """
        offered: Dict[str, Any] = {}

        def is_all_there() -> bool:
            offered.update(
                name=self._node.rpartition("/")[2],
                parameters={entry["name"]: entry["type"] for entry in self.described},
                **self._registered.of(self._node),
            )
            return not any(promises.broken(promised, offered))

        with contextlib.suppress(AssertionError):  # a test reports missing interfaces
            wait_until(is_all_there, lambda: "something is missing")
        return offered

    def change(self) -> List[str]:
        """Change each parameter that has another valid value; return the names of these."""
        return [entry["name"] for entry in self.described if any(map(self._set, *_tries(entry)))]

    def _set(self, name: str, value: Any) -> bool:
        return bool(self._call("change", SetParameters, yaml.safe_dump({name: value})).success)


def _tries(entry: Dict[str, Any]) -> Tuple[List[str], List[Any]]:
    values = [value for value in others(entry) if value != entry["value"]]
    return [entry["name"]] * len(values), values


class Dumped(unittest.TestCase):
    """A test for each node is added below."""

    root: Node
    changed: Dict[str, List[str]] = {}
    before: Dict[str, Dict[str, Any]] = {}
    after: Dict[str, Dict[str, Any]] = {}
    offered: Dict[str, Any] = {}

    @classmethod
    def setUpClass(cls) -> None:
        cls.root = init_node("test_dumped_parameters")
        cls.root.start()
        promised = promises.read()["nodes"]
        for module, settings in cls.started("/before"):
            cls.offered[module] = settings.offered(promised.get(module, {}))
            cls.changed[module] = settings.change()
            cls.before[module] = settings.in_force()
        with tempfile.NamedTemporaryFile(suffix=".yaml") as file:
            subprocess.check_call(["rosparam", "dump", file.name, "/before"])
            subprocess.check_call(["rosparam", "load", file.name, "/after"])
        for module, settings in cls.started("/after"):
            cls.after[module] = settings.in_force()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.root.close()

    @classmethod
    def started(cls, space: str) -> Iterator[Tuple[str, Settings]]:
        """Start the nodes one after the other, each in its own namespace below another."""
        for module in modules():
            name, node_class = node_of(module)
            before = interfaces.Registrations()
            node = cls.root.host(name, f"{space}/{module.replace('.', '/')}", node_class)
            try:
                yield module, Settings(node.name, before)
            finally:
                node.close()

    def test_what_is_left_out_is_still_there(self) -> None:
        for module in LEFT_OUT:
            self.assertIsNotNone(importlib.util.find_spec(module), module)

    def test_what_is_promised_is_kept(self) -> None:
        found = {**interfaces.of_packages(SOURCES), "nodes": self.offered}
        if os.environ.get("ADD_PROMISES"):
            promises.write(promises.merged(promises.read(), found))
        self.assertEqual(list(promises.broken(promises.read(), found)), [])

    def test_most_parameters_could_be_changed(self) -> None:
        total = sum(map(len, self.before.values()))
        changed = sum(map(len, self.changed.values()))
        self.assertGreater(changed, 0.8 * total, f"{changed} of {total}")


def _same(module: str) -> Callable[[Dumped], None]:
    def test(self: Dumped) -> None:
        self.assertEqual(self.after[module], self.before[module])
        self.assertTrue(self.changed[module] or not self.before[module], "nothing was changed")

    return test


for _module in modules():
    setattr(Dumped, "test_" + _module.replace(".", "_"), _same(_module))

if __name__ == "__main__":
    rosrun("basic_comms", "dumped_parameters", Dumped)
