#!/usr/bin/env python3
"""Panels: what nodes say of themselves, values that are set and refused, services, the graph."""

import subprocess
import time
from typing import Any, List

import roslib.packages
import rosnode
import rospy
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from std_srvs.srv import Trigger
from wire.client import Client
from wire.scope_test import ScopeTest

from nodekit.testing.changing import change
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

NODE = "/signal_generator"


class Controls(ScopeTest):
    """A scope beside the course's nodes; each test leaves their parameters as they were."""

    def panelled(self) -> Client:
        """Return a page that has the panels of both nodes."""
        page = self.page()

        def is_complete(message: Any) -> bool:
            return {"/process", NODE} <= {panel["node"] for panel in message["panels"]}

        self.panels = {
            panel["node"]: panel for panel in page.wait_for("panels", is_complete)["panels"]
        }
        return page

    def set(self, page: Client, name: str, value: Any) -> None:
        page.send("set", node=NODE, name=name, value=value)

    def restore(self, name: str) -> None:
        """Put a parameter back with the end of the test."""
        self.addCleanup(rospy.set_param, f"{NODE}/{name}", rospy.get_param(NODE + "/" + name))

    def test_a_panel_shows_what_the_node_says(self) -> None:
        self.panelled()
        shown = {entry["name"]: entry for entry in self.panels[NODE]["parameters"]}
        self.assertEqual(
            {key: shown["rate"][key] for key in ("kind", "unit", "above", "maximum", "minimum")},
            {"kind": "float", "unit": "Hz", "above": None, "maximum": 10000.0, "minimum": 1e-6},
        )
        self.assertEqual(shown["waveform"]["kind"], "enum")
        self.assertIn("square", shown["waveform"]["choices"])
        self.assertIs(shown["autostart"]["value"], True)
        self.assertEqual(shown["seed"]["kind"], "int")
        self.assertTrue(shown["amplitude"]["help"])
        services = self.panels[NODE]["services"]
        self.assertIn({"name": NODE + "/enable", "kind": "SetBool"}, services)
        self.assertIn({"name": NODE + "/reset", "kind": "Trigger"}, services)
        self.assertNotIn("describe", str(services))

    def test_a_value_comes_into_force_and_all_pages_know(self) -> None:
        one, other = self.panelled(), self.panelled()
        self.restore("amplitude")
        one.send("select", fields=["/signal/amplitude"])
        self.set(one, "amplitude", 3.25)
        for page in (one, other):
            page.wait_for(
                "value", lambda told: (told["name"], told["value"]) == ("amplitude", 3.25)
            )
        self.assertEqual(rospy.get_param(NODE + "/amplitude"), 3.25)
        wait_until(lambda: 3.25 in one.values("/signal/amplitude"), lambda: one.bins)
        self.assertEqual(one.messages("refused"), [])

    def test_a_value_out_of_range_is_refused_and_never_written(self) -> None:
        page = self.panelled()
        self.set(page, "rate", -1)
        refused = page.wait_for("refused")
        self.assertEqual((refused["node"], refused["name"], refused["value"]), (NODE, "rate", -1))
        self.assertIn("must be a number in [1e-06, 10000]", refused["text"])
        page.wait_for("value", lambda told: (told["name"], told["value"]) == ("rate", 100.0))
        self.set(page, "waveform", "wavy")
        page.wait_for("refused", lambda told: "one of sine, square" in told["text"])
        self.set(page, "autostart", 1)
        page.wait_for("refused", lambda told: "true or false" in told["text"])

    def test_the_node_has_the_last_word(self) -> None:
        """A value that is in range, but not with the others: only the node knows."""
        page, other = self.panelled(), self.panelled()
        before = rospy.get_param(NODE + "/multisine_amplitudes")
        self.set(page, "multisine_amplitudes", "[1.0, 2.0, 3.0]")
        refused = page.wait_for("refused")
        self.assertIn("three lists must have one length", refused["text"])
        told = ("multisine_amplitudes", "[1.0, 0.5]")
        page.wait_for("value", lambda value: (value["name"], value["value"]) == told)
        self.assertEqual(rospy.get_param(NODE + "/multisine_amplitudes"), before)
        self.assertEqual(other.messages("refused"), [])

    def test_a_number_with_a_comma_is_refused_by_the_node(self) -> None:
        page = self.panelled()
        before = rospy.get_param(NODE + "/amplitude")
        self.set(page, "amplitude", "1,000")
        page.wait_for("refused", lambda told: told["name"] == "amplitude")
        self.assertEqual(rospy.get_param(NODE + "/amplitude"), before)

    def test_lists_that_must_have_one_length_are_changed_one_after_the_other(self) -> None:
        page = self.panelled()
        names = ["multisine_" + part for part in ("amplitudes", "frequencies", "phases")]
        # All at once: one by one, they would be of different lengths for a while.
        before = {name: rospy.get_param(f"{NODE}/{name}") for name in names}
        self.addCleanup(change, NODE, **before)
        for name in names:
            self.set(page, name, "[1.0, 2.0, 3.0]")
            if name != names[-1]:
                page.wait_for("refused", lambda told: told["name"] == name)
        for name in names:
            page.wait_for(
                "value", lambda told: (told["name"], told["value"]) == (name, "[1.0, 2.0, 3.0]")
            )
            self.assertEqual(rospy.get_param(NODE + "/" + name), [1.0, 2.0, 3.0])

    def test_the_last_of_many_values_wins(self) -> None:
        page = self.panelled()
        self.restore("offset")
        for index in range(101):
            self.set(page, "offset", index / 100.0)
        wait_until(
            lambda: rospy.get_param(NODE + "/offset") == 1.0,
            lambda: rospy.get_param(NODE + "/offset"),
        )
        page.wait_for("value", lambda told: (told["name"], told["value"]) == ("offset", 1.0))
        self.assertEqual(page.messages("refused"), [])

    def test_a_change_by_anybody_is_shown(self) -> None:
        page = self.panelled()
        self.restore("phase")
        rospy.set_param(NODE + "/phase", 0.75)
        page.wait_for("value", lambda told: (told["name"], told["value"]) == ("phase", 0.75))
        page.forget()
        rospy.set_param(NODE + "/phase", "nonsense")  # the node puts it back
        wait_until(lambda: rospy.get_param(NODE + "/phase") == 0.75, lambda: "not put back")
        self.assertNotIn("nonsense", str(page.messages("value")))

    def test_services_are_called(self) -> None:
        page = self.panelled()
        page.send("call", service=NODE + "/reset")
        called = page.wait_for("called")
        self.assertEqual((called["service"], called["success"]), (NODE + "/reset", True))
        self.assertIn("start at 0", called["message"])
        page.send("call", service=NODE + "/enable", data=False)
        page.wait_for("called", lambda told: told["service"] == NODE + "/enable")
        page.forget()
        page.send("call", service=NODE + "/enable", data=True)
        self.assertTrue(page.wait_for("called")["success"])

    def test_only_what_has_a_button_can_be_called_or_set(self) -> None:
        page = self.panelled()
        requests = [
            ("call", {"service": "/signal_generator/set_logger_level"}),
            ("call", {"service": "/rosout/get_loggers"}),
            ("call", {"service": NODE + "/enable"}),
            ("set", {"node": NODE, "name": "undeclared", "value": 1}),
            ("set", {"node": "/", "name": "run_id", "value": 1}),
        ]
        for kind, content in requests:
            page.forget()
            page.send(kind, **content)
            page.wait_for("error")

    def test_the_graph_has_nodes_edges_and_rates(self) -> None:
        page = self.panelled()
        page.send("graph", on=True)
        expected = {"from": NODE, "to": "/process", "topic": "/signal"}

        def has_rate(graph: Any) -> bool:
            rates = [edge["rate"] for edge in graph["edges"] if expected.items() <= edge.items()]
            return len(rates) == 1 and rates[0] is not None and 80.0 < rates[0] < 120.0

        graph = page.wait_for("graph", has_rate)
        self.assertLessEqual({NODE, "/process"}, set(graph["nodes"]))
        self.assertIn({"name": "/signal", "datatype": "basic_comms/signal_msg"}, graph["topics"])
        own = "/scope_" + self.scope.url.rpartition(":")[2]
        self.assertIn(own, rosnode.get_node_names())
        self.assertNotIn(own, graph["nodes"])
        page.send("graph", on=False)
        page.send("foo")  # answered after that
        page.wait_for("error")
        page.forget()
        self.restore("phase")
        rospy.set_param(NODE + "/phase", 0.5)
        page.wait_for("value")
        self.assertEqual(page.messages("graph"), [])

    def test_a_node_that_ends_takes_its_panel_along(self) -> None:
        page = self.panelled()
        service = rospy.Service("/guest/describe", Trigger, _describe_guest)
        page.wait_for(
            "panels", lambda told: "/guest" in [panel["node"] for panel in told["panels"]]
        )
        page.forget()
        service.shutdown("ended by the test")
        page.wait_for(
            "panels", lambda told: "/guest" not in [panel["node"] for panel in told["panels"]]
        )

    def test_a_change_while_a_panel_is_made_is_not_lost(self) -> None:
        page = self.panelled()
        self.restore("amplitude")
        rospy.set_param("/slow/a", 1)
        self.addCleanup(rospy.delete_param, "/slow")

        def describe(request: Any) -> Any:
            rospy.set_param("/slow/a", 2)
            # The master tells a node of one change after the other: when the scope has learnt of
            # this one, it has learnt of the one before, and has no description yet.
            rospy.set_param(NODE + "/amplitude", 3.5)
            page.wait_for("value", lambda told: (told["name"], told["value"]) == ("amplitude", 3.5))
            return _describe_guest(request)

        service = rospy.Service("/slow/describe", Trigger, describe)
        self.addCleanup(service.shutdown)
        page.wait_for("value", lambda told: (told["node"], told["value"]) == ("/slow", 2))

    def test_a_description_that_makes_no_sense_is_no_panel(self) -> None:
        page = self.panelled()
        service = rospy.Service(
            "/babbler/describe", Trigger, lambda _: (True, "[!!python/object/new:os.system [id]]")
        )
        self.addCleanup(service.shutdown)
        guest = rospy.Service("/later/describe", Trigger, _describe_guest)
        self.addCleanup(guest.shutdown)
        page.wait_for(
            "panels", lambda told: "/later" in [panel["node"] for panel in told["panels"]]
        )
        self.assertNotIn("babbler", str(page.messages("panels")))

    def test_managed_nodes_have_states_and_transitions(self) -> None:
        program = roslib.packages.find_node("basic_comms", "talker.py")[0]
        command = [program, "__ns:=/managed", "_managed:=true"]
        talker = subprocess.Popen(command)
        self.addCleanup(talker.wait, 30.0)
        self.addCleanup(talker.terminate)
        node = "/managed/talker"
        page = self.page()

        def wait_state(state: str) -> Any:
            told = page.wait_for("managed", lambda told: (node, state) in states(told))
            return next(one for one in told["nodes"] if one["node"] == node)["transitions"]

        def states(told: Any) -> Any:
            return [(one["node"], one["state"]) for one in told["nodes"]]

        self.assertEqual(wait_state("unconfigured"), ["configure", "shutdown"])
        page.send("transition", node=node, label="configure")
        self.assertEqual(sorted(wait_state("inactive")), ["activate", "cleanup", "shutdown"])
        page.send("transition", node=node, label="activate")
        wait_state("active")
        page.send("transition", node=node, label="configure")
        self.assertIn(f"{node} cannot configure now", page.wait_for("error")["text"])
        page.send("transition", node="/nobody", label="configure")
        page.wait_for("error", lambda told: "/nobody cannot" in told["text"])
        page.forget()
        talker.kill()  # the master goes on to list its services
        self.assertEqual(wait_state("does not answer"), [])
        page.send("transition", node=node, label="deactivate")
        page.wait_for("error", lambda told: f"{node} cannot deactivate now" in told["text"])
        page.forget()
        talker = subprocess.Popen(command)  # another one of its name, which ends in order
        self.addCleanup(talker.wait, 30.0)
        self.addCleanup(talker.terminate)
        self.assertEqual(wait_state("unconfigured"), ["configure", "shutdown"])
        page.forget()
        talker.terminate()
        page.wait_for("managed", lambda told: states(told) == [])

    def test_a_managed_node_that_fails_is_left_out_and_asked_again_after_a_while(self) -> None:
        asked: List[float] = []

        def fail(_request: Any) -> Any:
            asked.append(time.monotonic())
            raise rospy.ServiceException("not today")

        kinds = (ChangeState, GetAvailableTransitions, GetState)
        names = ("change_state", "get_available_transitions", "get_state")
        for name, kind in zip(names, kinds):
            self.addCleanup(rospy.Service(f"/unwell/{name}", kind, fail).shutdown)
        wait_until(lambda: len(asked) > 2, lambda: f"it was asked {len(asked)} times")
        self.assertGreater(asked[2] - asked[0], 3.0)
        # A page is told of others nevertheless.
        self.assertNotIn("/unwell", str(self.page().wait_for("managed")))


def _describe_guest(_request: Any) -> Any:
    return True, "- {name: a, value: 1, type: int, unit: '', range: '[0, 5]', help: ''}"


if __name__ == "__main__":
    rospy.init_node("test_scope_controls")
    rosrun("topic_scope", "scope_controls", Controls)
