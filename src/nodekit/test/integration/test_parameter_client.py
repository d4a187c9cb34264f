#!/usr/bin/env python3
"""Tests of ParameterClient with a node, and with nodes that do not answer."""

import os
import time

import rospy
from helpers.parameter_node import GaugeParameters
from helpers.parameter_rig import HELPERS, ParameterCase, ParameterNode
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import (
    CallError,
    CallTimeout,
    ChangeRefused,
    DescriptionError,
    ParameterClient,
    ParameterError,
    parameter_of,
    to_wire,
)
from nodekit.testing.changing import change
from nodekit.testing.processes import Process, Server, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

GAUGE = "/client/gauge"
DEFAULTS = {name: to_wire(value) for name, value in GaugeParameters().as_dict().items()}


class WithANode(ParameterCase):
    """One node with parameters to read and change."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.server = Server()
        cls.node = ParameterNode(GAUGE)
        rospy.wait_for_service(GAUGE + "/change", TIMEOUT_S)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.node.end()

    def setUp(self) -> None:
        self.client = ParameterClient(GAUGE + "/", timeout=TIMEOUT_S)
        self.client.change(DEFAULTS)

    def test_describes_all_in_the_order_of_declaration(self) -> None:
        described = self.client.describe()
        self.assertEqual(list(described), list(GaugeParameters.declared))
        level = described["level"]
        self.assertEqual((level["value"], level["type"], level["unit"]), (1.0, "float", "V"))
        self.assertEqual((level["help"], level["minimum"]), ("a level", 0.0))
        with self.assertRaisesRegex(ParameterError, "level: refused -1: must be"):
            parameter_of(level).coerce(-1)

    def test_gets_the_values_in_force(self) -> None:
        self.assertEqual(self.client.get(), DEFAULTS)

    def test_changes_several_parameters_and_returns_all(self) -> None:
        same = [3.0, 4.0]
        in_force = self.client.change({"low": 20, "high": 30.0, "title": "ä: #", "marks": same})
        expected = {**DEFAULTS, "low": 20.0, "high": 30.0, "title": "ä: #", "marks": same}
        self.assertEqual(in_force, expected)
        self.assertEqual(self.client.get(), expected)
        self.node.wait_for(**expected)
        self.assert_truth(self.node, self.server)

    def test_accepts_a_tuple_for_a_list(self) -> None:
        self.assertEqual(self.client.change({"marks": (5.0,)})["marks"], [5.0])

    def test_refused_change_in_a_batch_has_no_effect(self) -> None:
        with self.assertRaises(ChangeRefused) as caught:
            self.client.change({"count": 5, "level": -1, "shape": "square"})
        self.assertIn(f"{GAUGE}/level: refused -1: must be", str(caught.exception))
        self.assertIn(f"{GAUGE}/shape: refused", str(caught.exception))
        self.assertEqual(self.client.get(), DEFAULTS)
        self.assert_truth(self.node, self.server)

    def test_an_unknown_name_is_refused_with_a_hint(self) -> None:
        with self.assertRaisesRegex(ChangeRefused, "levle.*did you mean level"):
            self.client.change({"levle": 2})

    def test_the_helper_of_tests_changes_and_refuses_as_well(self) -> None:
        change(GAUGE, count=8)
        self.assertEqual(self.client.get()["count"], 8)
        with self.assertRaises(ChangeRefused):
            change(GAUGE, count=-8)

    def test_no_value_of_a_parameter_is_not_sent(self) -> None:
        with self.assertRaisesRegex(ValueError, "not a value of a parameter"):
            self.client.change({"count": object()})


class Silence(ParameterCase):
    """Nodes that do not answer, or with malformed replies, each in its own namespace."""

    def test_unknown_node(self) -> None:
        client = ParameterClient("/client/missing")
        for ask in (client.describe, client.get, lambda: client.change({"a": 1})):
            with self.assertRaisesRegex(CallError, "/client/missing/.*: no node offers it"):
                ask()

    def test_node_without_parameters_of_nodekit(self) -> None:
        slow = self._slow_server("describe")
        with self.assertRaisesRegex(CallError, "/client/slow/change .*no node offers it"):
            ParameterClient("/client/slow").change({"a": 1})
        slow.end()

    def test_node_that_does_not_answer_in_time(self) -> None:
        self._slow_server("describe")
        began = time.monotonic()
        with self.assertRaisesRegex(CallTimeout, "no answer within 0.5 s"):
            ParameterClient("/client/slow", timeout=0.5).describe()
        self.assertLess(time.monotonic() - began, 15.0)  # the server sleeps for a minute

    def test_node_that_is_stopped_does_not_answer_a_change(self) -> None:
        node = self.start_node("/client/stopped")
        rospy.wait_for_service("/client/stopped/change", TIMEOUT_S)
        with hanging(node.popen.pid), self.assertRaises(CallTimeout):
            ParameterClient("/client/stopped", timeout=0.5).change({"count": 4})

    def test_node_that_vanishes_between(self) -> None:
        node = self.start_node("/client/gone")
        rospy.wait_for_service("/client/gone/change", TIMEOUT_S)
        client = ParameterClient("/client/gone", timeout=TIMEOUT_S)
        self.assertEqual(client.get(), DEFAULTS)
        node.popen.kill()
        node.popen.wait()
        with self.assertRaisesRegex(CallError, "/client/gone/change cannot be called"):
            client.change({"count": 4})

    def test_service_of_that_name_without_a_description(self) -> None:
        service = rospy.Service(
            "/client/other/describe", Trigger, lambda _: TriggerResponse(True, "all is well")
        )
        self.addCleanup(service.shutdown)
        with self.assertRaisesRegex(DescriptionError, "/client/other/describe sent a malformed"):
            ParameterClient("/client/other").describe()

    def _slow_server(self, name: str) -> Process:
        server = Process(
            os.path.join(HELPERS, "slow_server.py"),
            [f"slow:=/client/slow/{name}", "__name:=slow"],
            {"ROS_NAMESPACE": "/client"},
        )
        self.addCleanup(server.end)
        wait_until(lambda: server.lines, lambda: f"start: {server.logged()}")
        return server


if __name__ == "__main__":
    rospy.init_node("test_parameter_client")
    rosrun("nodekit", "parameter_client", "test_parameter_client")
