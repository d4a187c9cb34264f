#!/usr/bin/env python3
"""Tests of service clients on a real master: servers that answer, hang, fail and die."""

import itertools
import os
import socket
import time
import unittest
from typing import Any, List
from unittest import mock

import rosgraph
import rospy
from roscpp.srv import GetLoggers, GetLoggersRequest
from std_srvs.srv import SetBool, SetBoolRequest, Trigger, TriggerRequest, TriggerResponse

from nodekit import (
    CallCancelled,
    CallError,
    CallFuture,
    CallTimeout,
    Group,
    MultiThreadedExecutor,
    NestedCall,
    SingleThreadedExecutor,
)
from nodekit.node.clients import MOST_CALLS
from nodekit.node.names import Names
from nodekit.node.ros_node import Node
from nodekit.process.run import init_node
from nodekit.testing.processes import Process, hanging
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

HELPERS = os.path.join(os.path.dirname(__file__), "..", "helpers")
SERVER = os.path.join(HELPERS, "slow_server.py")


class Clients(unittest.TestCase):
    """Each test has its own namespace."""

    numbers = itertools.count()

    def setUp(self) -> None:
        self.space = f"/clients{next(self.numbers)}"
        self.node = Node(Names.hosted(self.space, "client"))
        self.addCleanup(self.node.close)
        self.node.start()

    def server(self) -> Process:
        """Start a server in this test's namespace, and wait until it can be called."""
        server = Process(SERVER, [f"__ns:={self.space}"])
        self.addCleanup(server.end)
        is_there = self.node.create_client("fails", Trigger).wait_for_service(TIMEOUT_S)
        self.assertTrue(is_there, server.logged())
        return server

    def test_answers_of_stock_rospy(self) -> None:
        self.server()
        client = self.node.create_client("echo", SetBool)
        # A look of 0.1 s may be too short on a busy machine, but not each time.
        wait_until(lambda: client.wait_for_service(0.0), lambda: "not found without waiting")
        for wanted in (True, False):
            self.assertEqual(client.call(SetBoolRequest(wanted)).success, wanted)
        with self.assertRaisesRegex(CallError, "replied with an error: .*on purpose"):
            self.node.create_client("fails", Trigger).call(TriggerRequest())

    def test_answers_of_roscpp(self) -> None:
        client = self.node.create_client("/relay/get_loggers", GetLoggers)
        self.assertTrue(client.wait_for_service(TIMEOUT_S))
        self.assertTrue(client.call(GetLoggersRequest()).loggers)

    @extended
    def test_hundred_simultaneous_calls_never_swap_answers(self) -> None:
        """Course err-6."""
        self.server()
        client = self.node.create_client("echo", SetBool)
        wanted = [number % 3 == 0 for number in range(100)]
        # Stock rospy lets five wait to be taken; the kernel tries again for the rest, ever later.
        patience = 4.0 * TIMEOUT_S
        futures = [client.call_async(SetBoolRequest(data), patience) for data in wanted]
        self.assertEqual([future.result().success for future in futures], wanted)
        wait_until(lambda: not client.running_calls, lambda: str(client.running_calls))

    def test_done_callback_runs_in_the_group(self) -> None:
        self.server()
        group = Group()
        client = self.node.create_client("echo", SetBool, group=group)
        told: List[Any] = []
        with group:
            future = client.call_async(SetBoolRequest(True))
            future.add_done_callback(lambda done: told.append(done.result().message))
            self.assertEqual(future.result().message, "quick")
            self.assertEqual(told, [])
        wait_until(lambda: told == ["quick"], lambda: str(told))
        future.add_done_callback(lambda done: told.append("late"))
        wait_until(lambda: told == ["quick", "late"], lambda: str(told))

    def test_hanging_server_costs_the_time_out_and_its_late_answer_is_dropped(self) -> None:
        server = self.server()
        client = self.node.create_client("slow", Trigger)
        told: List[CallFuture] = []
        future = client.call_async(TriggerRequest(), 0.3)
        future.add_done_callback(told.append)
        began = time.monotonic()
        with self.assertRaisesRegex(CallTimeout, f"{self.space}/slow: no answer within 0.3 s"):
            client.call(TriggerRequest(), timeout=0.3)
        self.assertLess(time.monotonic() - began, TIMEOUT_S / 2)
        wait_until(future.done, lambda: "not done")
        assert server.popen.stdin is not None
        server.popen.stdin.write("answer\n")
        self.assertEqual(client.call(TriggerRequest()).message, "at last")
        with self.assertRaises(CallTimeout):
            future.result()
        wait_until(lambda: told == [future], lambda: str(told))
        self.assertEqual(client.running_calls, set())

    def test_hanging_master_costs_the_time_out_too(self) -> None:
        client = self.node.create_client("slow", Trigger)
        with socket.socket() as silent:
            silent.bind(("localhost", 0))
            silent.listen(1)
            uri = f"http://localhost:{silent.getsockname()[1]}"
            with mock.patch.dict(os.environ, ROS_MASTER_URI=uri):
                future = client.call_async(TriggerRequest(), 0.3)
                wait_until(future.done, lambda: "not done")
        with self.assertRaisesRegex(CallTimeout, f"{self.space}/slow: no answer within 0.3 s"):
            future.result()

    def test_cancelled_call_raises_and_closes_its_connection(self) -> None:
        self.server()
        client = self.node.create_client("slow", Trigger)
        future = client.call_async(TriggerRequest(), TIMEOUT_S)
        self.assertFalse(future.done())
        self.assertTrue(future.cancel())
        with self.assertRaisesRegex(CallCancelled, f"the call of {self.space}/slow was cancelled"):
            future.result()
        wait_until(lambda: not client.running_calls, lambda: "its thread still waits")
        self.assertTrue(future.cancelled() and future.done())

    def test_closing_ends_running_calls(self) -> None:
        self.server()
        part = self.node.create_scope()
        client = part.create_client("slow", Trigger)
        future = client.call_async(TriggerRequest(), TIMEOUT_S)
        part.close()
        with self.assertRaises(CallCancelled):
            future.result()
        with self.assertRaisesRegex(CallCancelled, "its client is closed"):
            client.call(TriggerRequest())

    @extended
    def test_ctrl_c_ends_a_node_with_hung_calls_and_sleeping_callbacks(self) -> None:
        self.server()
        node = Process(os.path.join(HELPERS, "waiting_client.py"), [f"__ns:={self.space}"])
        self.addCleanup(node.end)
        node.wait_for_log("asked")
        began = time.monotonic()
        self.assertEqual(node.interrupt(), 0)
        self.assertLess(time.monotonic() - began, TIMEOUT_S / 2)
        self.assertEqual(node.logged("Traceback"), [])
        self.assertEqual(len(node.logged(f"the call of {self.space}/slow was cancelled")), 1)

    @extended
    def test_calls_under_way_are_bounded(self) -> None:
        self.server()
        client = self.node.create_client("slow", Trigger)
        for _ in range(MOST_CALLS):
            client.call_async(TriggerRequest(), TIMEOUT_S)
        with self.assertRaisesRegex(CallError, f"{MOST_CALLS} calls are running already"):
            client.call_async(TriggerRequest())
        client.close()

    @extended
    def test_server_that_is_killed_stopped_and_started_again(self) -> None:
        server = self.server()
        client = self.node.create_client("slow", Trigger)
        future = client.call_async(TriggerRequest(), TIMEOUT_S)
        wait_until(lambda: self.connections(server) > 0, lambda: "not connected")
        server.end()
        with self.assertRaisesRegex(CallError, f"{self.space}/slow cannot be called: "):
            future.result()
        # It stays registered with the master: the connection is refused.
        with self.assertRaisesRegex(CallError, "cannot be called: .*refused"):
            client.call(TriggerRequest())
        with self.assertLogs("rosout", "INFO") as logged:
            self.assertFalse(client.wait_for_service(1.5))
        self.assertRegex(logged.output[0], "slow cannot be called: .*refused; waiting again")
        again = self.server()
        quick = self.node.create_client("echo", SetBool)
        self.assertTrue(quick.call(SetBoolRequest(True)).success)
        with hanging(again.popen.pid):
            with self.assertRaises(CallTimeout):
                quick.call(SetBoolRequest(True), timeout=0.3)
            self.assertFalse(quick.wait_for_service(0.3))
        self.assertTrue(quick.call(SetBoolRequest(True), TIMEOUT_S).success)

    def connections(self, server: Process) -> int:
        """Return how many sockets a process has."""
        directory = f"/proc/{server.popen.pid}/fd"
        links = [os.path.realpath(f"{directory}/{name}") for name in os.listdir(directory)]
        return len([link for link in links if "socket" in link])

    def test_missing_service_and_server_that_is_not_a_service(self) -> None:
        client = self.node.create_client("nowhere", Trigger)
        with self.assertRaisesRegex(CallError, f"{self.space}/nowhere cannot be called: no node"):
            client.call(TriggerRequest())
        began = time.monotonic()
        self.assertFalse(client.wait_for_service(0.2))
        self.assertLess(time.monotonic() - began, TIMEOUT_S / 2)
        master = rosgraph.Master(self.space + "/liar")

        def register_at(uri: str) -> None:
            master.registerService(self.space + "/nowhere", uri, "http://localhost:1/")
            self.addCleanup(master.unregisterService, self.space + "/nowhere", uri)

        for uri in ("rosrpc://nonsense:x", "rosrpc://localhost:99999", f"rosrpc://{'a' * 64}:1"):
            register_at(uri)
            with self.assertRaisesRegex(CallError, f"cannot be called: .*{uri}"):
                client.call(TriggerRequest())
            self.assertFalse(client.wait_for_service(0.0))
        with socket.socket() as silent:
            silent.bind(("localhost", 0))
            silent.listen(1)
            register_at(f"rosrpc://localhost:{silent.getsockname()[1]}")
            with self.assertRaises(CallTimeout):
                client.call(TriggerRequest(), timeout=0.2)

    def test_wrong_types_and_values_are_refused_in_words(self) -> None:
        self.server()
        with self.assertRaisesRegex(CallError, "replied with an error: .*md5"):
            self.node.create_client("echo", Trigger).call(TriggerRequest())
        client = self.node.create_client("echo", SetBool)
        with self.assertRaisesRegex(CallError, "refused True: must be a SetBoolRequest"):
            client.call(True)
        with self.assertRaisesRegex(CallError, "request is refused: "):
            client.call(SetBoolRequest("text"))
        for timeout in (0.0, -1.0, 1e10, float("inf"), float("nan")):
            with self.assertRaisesRegex(ValueError, f"refused {timeout} s: must be"):
                client.call(SetBoolRequest(True), timeout=timeout)

    def served(self, executor: Any, same_group: bool) -> List[Any]:
        """Call a service of this process from a callback of its node; return the result."""
        outcome: List[Any] = []
        if executor is not None:
            executor.add_node(self.node)
            self.addCleanup(executor.shutdown)
        group = None if same_group else Group()
        self.node.create_service(
            "own", Trigger, lambda request: TriggerResponse(True, "hello"), group
        )
        client = self.node.create_client("own", Trigger)

        def ask(request: Any) -> TriggerResponse:
            for call in (
                lambda: client.call(TriggerRequest(), timeout=TIMEOUT_S).message,
                lambda: client.call_async(TriggerRequest(), timeout=TIMEOUT_S).result().message,
            ):
                try:
                    outcome.append(call())
                except CallError as error:
                    outcome.append(type(error))
            return TriggerResponse(True, "")

        self.node.create_service("ask", Trigger, ask)
        rospy.ServiceProxy(self.space + "/ask", Trigger)()
        return outcome

    def test_nested_call_to_the_own_group_is_refused(self) -> None:
        self.assertEqual(self.served(None, same_group=True), [NestedCall] * 2)

    def test_nested_call_to_the_own_group_is_refused_in_an_executor(self) -> None:
        self.assertEqual(self.served(MultiThreadedExecutor(3), same_group=True), [NestedCall] * 2)

    def test_nested_call_to_the_only_thread_is_refused(self) -> None:
        self.assertEqual(self.served(SingleThreadedExecutor(), same_group=False), [NestedCall] * 2)

    def test_nested_call_that_is_refused_is_not_sent(self) -> None:
        came: List[Any] = []

        def count(request: Any) -> TriggerResponse:
            came.append(request)
            return TriggerResponse(True, "")

        self.node.create_service("own", Trigger, count)
        client = self.node.create_client("own", Trigger)

        def ask(request: Any) -> TriggerResponse:
            for _ in range(5):
                with self.assertRaisesRegex(NestedCall, "own is not called"):
                    client.call(TriggerRequest(), timeout=TIMEOUT_S)
            return TriggerResponse(True, "")

        self.node.create_service("ask", Trigger, ask)
        for name in ("ask", "own", "own"):
            self.assertTrue(rospy.ServiceProxy(f"{self.space}/{name}", Trigger)().success)
        self.assertEqual(len(came), 2)

    def test_nested_call_to_another_group_is_answered(self) -> None:
        self.assertEqual(self.served(None, same_group=False), ["hello"] * 2)

    def test_nested_call_to_another_thread_is_answered(self) -> None:
        self.assertEqual(self.served(MultiThreadedExecutor(3), same_group=False), ["hello"] * 2)

    def test_answer_that_its_type_cannot_hold_is_an_error_for_the_client(self) -> None:
        self.node.create_service("bad", Trigger, lambda request: TriggerResponse(True, 5))
        client = self.node.create_client("bad", Trigger)
        for _ in range(2):
            with self.assertRaisesRegex(CallError, "replied with an error"):
                client.call(TriggerRequest(), timeout=TIMEOUT_S)


if __name__ == "__main__":
    init_node("test_clients")
    rosrun("nodekit", "clients", "test_clients")
