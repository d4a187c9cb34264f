#!/usr/bin/env python3
"""The manager with real nodes, in this process or in others that are killed."""

import itertools
import os
import threading
import time
import unittest
from typing import Any, Callable, Dict, List

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import Trigger, TriggerResponse

from lifecycle_manager.nodes.lifecycle_manager import LifecycleManager
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nodekit import (
    ChangeRefused,
    ManagedNode,
    Names,
    Node,
    ParameterClient,
    ParameterError,
    init_node,
)
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process, Server, hanging
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from nodekit_msgs.srv import ManageNodes, ManageNodesRequest, ManageNodesResponse

HERE = os.path.dirname(os.path.realpath(__file__))
MANAGER = os.path.join(HERE, "..", "..", "scripts", "lifecycle_manager")
DRIVER = os.path.join(HERE, "..", "helpers", "driver.py")
LATE_RIVAL = os.path.join(HERE, "..", "helpers", "late_rival.py")

ABC = ("a", "b", "c")
#: Long enough that a busy machine loses no node.
PATIENT_S = 20.0
#: Time without a heartbeat after which a stopped node is lost [s]: a busy machine loses no other.
STOPPED_S = 5.0
UP = [f"{name} {label}" for label in ("configure", "activate") for name in ABC]
DEACTIVATED = [f"{name} deactivate" for name in reversed(ABC)]
CLEANED = [f"{name} cleanup" for name in reversed(ABC)]


class Driver(ManagedNode):
    """Logs its transitions with the other nodes of its system, and fails as a test plans."""

    def __init__(self, node: Node, log: List[str], plan: Dict[str, Callable[[], Any]]) -> None:
        super().__init__(node)
        self.plan, self._log = plan, log

    def do(self, label: str) -> Any:
        what = f"{self.node.name.rpartition('/')[2]} {label}"
        self._log.append(what)
        return self.plan.get(what, lambda: None)()

    def on_configure(self, made: Any) -> Any:
        return self.do("configure")

    def on_activate(self, made: Any) -> Any:
        return self.do("activate")

    def on_deactivate(self) -> Any:
        return self.do("deactivate")

    def on_cleanup(self) -> Any:
        return self.do("cleanup")

    def on_shutdown(self) -> Any:
        return self.do("shutdown")


class Managing(unittest.TestCase):
    """Each test has its own namespace."""

    numbers = itertools.count()

    def setUp(self) -> None:
        self.space = f"/system{next(self.numbers)}"
        self.log: List[str] = []
        self.plan: Dict[str, Callable[[], Any]] = {}

    def set_parameters(self, name: str = "manager", **values: Any) -> None:
        values = {"node_names": ABC, "heartbeat_timeout": PATIENT_S, **values}
        for key, value in values.items():
            Server().set(f"{self.space}/{name}/{key}", value)

    def call(self, name: str, kind: Any, *arguments: Any) -> Any:
        service = f"{self.space}/{name}"
        rospy.wait_for_service(service, TIMEOUT_S)
        return rospy.ServiceProxy(service, kind)(*arguments)

    def command(self, number: int) -> ManageNodesResponse:
        return self.call("manager/manage_nodes", ManageNodes, number)

    def is_active(self) -> TriggerResponse:
        return self.call("manager/is_active", Trigger)

    def wait_until_active(self) -> None:
        wait_until(lambda: self.is_active().success, lambda: self.is_active().message)

    def wait_until_told(self, text: str) -> None:
        wait_until(
            lambda: text in self.is_active().message,
            lambda: f"{text!r} in {self.is_active().message!r}",
        )

    def states(self) -> List[str]:
        return [self.call(f"{name}/get_state", GetState).current_state.label for name in ABC]

    def change(self, name: str, label: str) -> bool:
        return bool(self.call(f"{name}/change_state", ChangeState, Transition(0, label)).success)


class Here(Managing):
    """All nodes, and their manager, in this process."""

    def node(self, name: str) -> Node:
        node = Node(Names.hosted(self.space, name))
        self.addCleanup(node.close)
        return node

    def drivers(self, *names: str) -> Dict[str, Node]:
        nodes = {name: self.node(name) for name in names}
        for node in nodes.values():
            Driver(node, self.log, self.plan)
            node.start()
        return nodes

    def manager(self, **values: Any) -> Node:
        self.set_parameters(**values)
        node = self.node("manager")
        LifecycleManager(node)
        node.start()
        return node

    def test_commands(self) -> None:
        """All are configured in order, then activated; down in reverse."""
        self.drivers(*ABC)
        recorder = MessageRecorder("/diagnostics", DiagnosticArray)
        self.addCleanup(recorder.close)
        self.manager()
        recorder.wait_for(lambda message: True)
        began, before = time.monotonic(), recorder.count()
        on, off = UP, DEACTIVATED
        for command, success, text, expected in (
            ("PAUSE", False, "PAUSE is refused while all are to be unconfigured", []),
            ("RESUME", False, "allowed: STARTUP, RESET, SHUTDOWN, CONFIGURE, CLEANUP", []),
            ("STARTUP", True, "all are active", on),
            ("STARTUP", True, "all are active", []),
            ("CONFIGURE", False, "CONFIGURE is refused while all are to be active", []),
            ("CLEANUP", False, "allowed: STARTUP, PAUSE, RESUME, RESET, SHUTDOWN", []),
            ("PAUSE", True, "all are inactive", off),
            ("RESUME", True, "all are active", on[3:]),
            ("RESET", True, "all are unconfigured", off + CLEANED),
            ("CONFIGURE", True, "all are inactive", on[:3]),
            ("CLEANUP", True, "all are unconfigured", CLEANED),
            ("STARTUP", True, "all are active", on),
            ("SHUTDOWN", True, "all are finalized", [*off, *CLEANED, *"c b a".split()]),
        ):
            del self.log[:]
            with self.subTest(command=command, text=text):
                answer = self.command(getattr(ManageNodesRequest, command))
                self.assertEqual(answer.success, success, answer)
                self.assertIn(text, answer.message)
                self.assertEqual([each.replace(" shutdown", "") for each in self.log], expected)
                self.assertEqual(self.is_active().success, self.states() == ["active"] * 3)
        # Each change was reported, not only the state once a second.
        self.assertGreater(recorder.count() - before, time.monotonic() - began + 2.0)
        answer = self.command(7)
        self.assertFalse(answer.success)
        self.assertIn("refused 7: must be one of 0 STARTUP, 1 PAUSE", answer.message)

    def test_what_fails_comes_down_in_order(self) -> None:
        self.drivers(*ABC)
        self.plan["c activate"] = lambda: False
        recorder = MessageRecorder("/diagnostics", DiagnosticArray)
        self.addCleanup(recorder.close)
        self.manager()
        failure = f"{self.space}/c: activate failed: it is inactive; its log says why"
        answer = self.command(ManageNodesRequest.STARTUP)
        self.assertEqual((answer.success, answer.message), (False, failure))
        self.assertEqual(self.log, UP + DEACTIVATED[1:] + CLEANED)
        self.assertEqual(self.states(), ["unconfigured"] * 3)
        manager = f"{self.space}/manager".lstrip("/")
        whole = f"{manager}: system"
        recorder.wait_for(lambda message: told(message, whole) == (DiagnosticStatus.ERROR, failure))
        self.plan.clear()
        self.assertTrue(self.command(ManageNodesRequest.STARTUP).success)
        recorder.wait_for(lambda message: told(message, whole) == (0, "all are active"))
        recorder.wait_for(lambda message: told(message, f"{manager}: {self.space}/c")[0] == 0)
        count = recorder.count()
        wait_until(lambda: recorder.count() > count, lambda: "reports without a change")

    def test_an_error_while_configuring(self) -> None:
        self.drivers(*ABC)
        self.plan["b configure"] = raising
        self.manager(autostart=True)
        self.wait_until_told(f"{self.space}/b: configure failed: it is unconfigured")
        wait_until(lambda: self.states() == ["unconfigured"] * 3, lambda: str(self.states()))
        self.assertEqual(self.log, ["a configure", "b configure", "a cleanup"])

    def test_one_that_does_not_let_itself_be_deactivated(self) -> None:
        """Nodes before it are deactivated, but stay configured as long as it is active."""
        self.drivers(*ABC)
        self.manager(autostart=True)
        self.wait_until_active()
        self.plan["b deactivate"] = lambda: False
        answer = self.command(ManageNodesRequest.RESET)
        self.assertFalse(answer.success)
        self.assertIn("b: deactivate failed: it is active", answer.message)
        self.assertEqual(self.states(), ["inactive", "active", "unconfigured"])
        self.plan.clear()
        self.assertTrue(self.command(ManageNodesRequest.RESET).success)

    @extended
    def test_one_that_takes_too_long(self) -> None:
        self.drivers(*ABC)
        go_on = threading.Event()
        self.addCleanup(go_on.set)
        self.plan["b configure"] = lambda: go_on.wait(TIMEOUT_S)
        self.manager(request_timeout=3.0)  # or a busy machine has not begun by then
        answer = self.command(ManageNodesRequest.STARTUP)
        self.assertFalse(answer.success)
        self.assertIn("b: configure failed", answer.message)
        self.assertIn("no answer within 3 s", answer.message)
        self.assertEqual(self.states(), ["unconfigured", "configuring", "unconfigured"])
        go_on.set()  # it is configured after all, and cleaned up then
        wait_until(lambda: "b cleanup" in self.log, lambda: str(self.log))

    def test_a_command_that_another_one_overtakes_is_answered(self) -> None:
        self.drivers(*ABC)
        go_on = threading.Event()
        self.addCleanup(go_on.set)
        self.plan["b configure"] = lambda: go_on.wait(TIMEOUT_S)
        self.manager(request_timeout=TIMEOUT_S)  # not even on a busy machine
        answers: List[ManageNodesResponse] = []

        def send(command: int) -> None:
            threading.Thread(
                target=lambda: answers.append(self.command(command)), daemon=True
            ).start()

        send(ManageNodesRequest.STARTUP)
        wait_until(lambda: "b configure" in self.log, lambda: str(self.log))
        send(ManageNodesRequest.RESET)
        # Before the other node is done, which a hanging node would delay.
        wait_until(lambda: answers, lambda: "the first is not answered")
        first = answers[0]
        self.assertEqual((first.success, first.message), (False, "superseded by another command"))
        go_on.set()
        wait_until(lambda: answers[1:], lambda: "the second is not answered")
        second = answers[1]
        self.assertEqual((second.success, second.message), (True, "all are unconfigured"))

    @extended
    def test_one_that_is_not_there(self) -> None:
        nodes = self.drivers("a", "b")
        self.manager(respawn_window=0.5, heartbeat_timeout=0.8)
        answer = self.command(ManageNodesRequest.STARTUP)
        text = f"{self.space}/c has been absent for longer than 0.5 s"
        self.assertFalse(answer.success)
        self.assertIn(text, answer.message)
        self.wait_until_told(text)
        self.assertNotIn("a activate", self.log)
        # It comes back later, and stays down until a command.
        nodes.update(self.drivers("c"))
        wait_until(
            lambda: self.command(ManageNodesRequest.STARTUP).success, lambda: str(self.states())
        )
        # A node that never comes back.
        nodes["a"].close()
        self.wait_until_told(f"{self.space}/a has been absent for longer than 0.5 s")
        wait_until(
            lambda: [self.log[-4:]] == [[*DEACTIVATED[:2], *CLEANED[:2]]], lambda: str(self.log)
        )

    def test_what_others_change_is_undone(self) -> None:
        self.drivers(*ABC)
        self.manager(autostart=True)
        self.wait_until_active()
        del self.log[:]
        self.assertTrue(self.change("a", "deactivate"))
        wait_until(lambda: len(self.log) == 6, lambda: str(self.log))
        self.assertEqual(self.log, ["a deactivate", *DEACTIVATED[:2], *UP[3:]])
        self.wait_until_active()

    def test_a_manager_that_comes_back(self) -> None:
        """The manager adopts the states it finds, and interrupts nothing."""
        self.drivers(*ABC)
        for autostart in (True, False):
            for command, text in (("STARTUP", "all are active"), ("PAUSE", "all are inactive")):
                with self.subTest(command=command, autostart=autostart):
                    manager = self.manager(autostart=autostart)
                    self.command(getattr(ManageNodesRequest, command))
                    manager.close()
                    del self.log[:]
                    manager = self.manager(autostart=autostart)
                    self.wait_until_told(text)
                    self.assertEqual(self.command(ManageNodesRequest.RESUME).success, True)
                    self.assertEqual(self.log, UP[3:] if command == "PAUSE" else [])
                    manager.close()

    @extended
    def test_at_its_end_what_hangs_is_left_behind(self) -> None:
        self.drivers(*ABC)
        self.set_parameters(autostart=True)
        node = self.node("manager")
        manager = LifecycleManager(node)
        node.start()
        self.wait_until_active()
        go_on = threading.Event()
        self.addCleanup(go_on.set)
        self.plan["c deactivate"] = lambda: go_on.wait(TIMEOUT_S)
        with self.assertLogs("rosout", "WARNING") as logged:
            manager.end()
        left = ", ".join(f"{self.space}/{name}" for name in ABC)
        self.assertIn(f"left in their current states: {left}", logged.output[-1])

    def test_names_are_validated(self) -> None:
        """At startup, and at run time, when they would take effect at the next start."""
        refused = {
            "a list of node names without duplicates": ([], ["a", "a"], ["a", self.space + "/a"]),
            "names of nodes, relative or global": ([""], ["a", "/"], ["~a"]),
            "other nodes than the manager itself": (["manager"], [f"{self.space}/manager"]),
            "must be letters": (["a b"], ["a", "ä"]),
        }
        for why, lists in refused.items():
            for names in lists:
                self.set_parameters(node_names=names)
                with self.assertRaisesRegex(ParameterError, f"/node_names: refused .*{why}"):
                    LifecycleManager(self.node("manager"))
        node = self.manager(node_names=["x"])
        for why, lists in refused.items():
            for names in lists:
                with self.assertRaisesRegex(ChangeRefused, f"/node_names: refused .*{why}"):
                    ParameterClient(node.name, TIMEOUT_S).change({"node_names": names})
        server, key = Server(), node.name + "/node_names"
        server.set(key, [""])
        server.wait_for(key, ["x"])
        ParameterClient(node.name, TIMEOUT_S).change({"node_names": ["y", "/z/y"]})
        self.assertEqual(server.get(key), ["y", "/z/y"])


def told(message: DiagnosticArray, name: str) -> Any:
    """Return level and text of a status; -1 if it is missing."""
    found = [(each.level, each.message) for each in message.status if each.name == name]
    return found[0] if found else (-1, "")


def raising() -> None:
    raise ValueError("on purpose")


class Elsewhere(Managing):
    """Processes of their own."""

    def start(self, script: str, name: str) -> Process:
        process = Process(script, [f"__name:={name}", f"__ns:={self.space}"])
        self.addCleanup(process.end)
        return process

    @extended
    def test_a_second_manager_that_starts_at_the_same_time(self) -> None:
        """It detects the first manager only after its own registration."""
        self.set_parameters("other", node_names=["y"])
        other = self.start(LATE_RIVAL, "other")
        self.assertEqual(other.wait(), 1)
        self.assertTrue(
            other.logged("nodes that have no other manager (y has one)"), other.logged()
        )
        self.assertEqual(other.logged("Traceback"), [])

    def wait_for_lines(self, **expected: List[str]) -> None:
        """Wait until these are the last lines of these nodes."""

        def found() -> Dict[str, List[str]]:
            return {name: self.nodes[name].lines[-len(lines) :] for name, lines in expected.items()}

        wait_until(lambda: found() == expected, lambda: f"{found()}, not {expected}")

    @extended
    def test_losses(self) -> None:
        """A system survives kill -9 and a stop of any node, and of its manager."""
        self.set_parameters(autostart=True)
        self.nodes = nodes = {name: self.start(DRIVER, name) for name in ABC}
        manager = self.start(MANAGER, "manager")
        manager.wait_for_log("all are active")
        self.assertEqual(manager.logged("get_state"), [])  # it has asked, and changed nothing
        # Killed and started again.
        nodes["b"].end()
        self.wait_until_told("b is lost: it has ended")
        self.wait_for_lines(a=["activate", "deactivate"], c=["deactivate", "cleanup"])
        nodes["b"] = self.start(DRIVER, "b")
        self.wait_until_active()
        self.wait_for_lines(a=["deactivate", "activate"], b=["configure", "activate"])
        self.assertEqual(len(manager.logged("all are active")), 2)  # once each time
        # Stopped, and continued: it was active all the time.
        with hanging(nodes["c"].popen.pid):
            self.set_parameters(heartbeat_timeout=STOPPED_S)
            self.wait_until_told(f"c is lost: no heartbeat for {STOPPED_S:g} s")
            self.set_parameters()
        self.wait_until_active()
        self.wait_for_lines(c=["deactivate", "activate"])
        # A suspended manager counts: another one is refused.
        lines = {name: list(nodes[name].lines) for name in ABC}
        with hanging(manager.popen.pid):
            self.set_parameters("second")
            second = self.start(MANAGER, "second")
            self.assertEqual(second.wait(), 1)
            text = f"must be nodes that have no other manager ({self.space}/a is managed by"
            self.assertTrue(second.logged(text, f"{self.space}/manager)"), second.logged())
        self.wait_until_active()
        # After it was killed, another manager of another name takes over, and interrupts nothing.
        manager.end()
        self.set_parameters("second", autostart=True)
        manager = self.start(MANAGER, "second")
        manager.wait_for_log("all are active")
        self.assertEqual({name: nodes[name].lines for name in ABC}, lines)
        # Ctrl-C brings the nodes down.
        self.assertEqual(manager.interrupt(), 0)
        self.assertEqual(self.states(), ["unconfigured"] * 3)
        self.wait_for_lines(**{name: ["deactivate", "cleanup"] for name in ABC})


if __name__ == "__main__":
    init_node("test_lifecycle_manager")
    rosrun("lifecycle_manager", "lifecycle_manager", "test_lifecycle_manager")
