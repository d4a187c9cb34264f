"""Panels of nodes that start, stop and fail, services, and managed nodes."""

import subprocess
import time
from typing import Any, List

import roslib.packages
import rospy
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from std_srvs.srv import Trigger
from wire.controls_test import NODE, ControlsTest, describe_guest

from nodekit.testing.waiting import wait_until


class Controls(ControlsTest):
    """Scope beside the course's nodes; each test restores their parameters."""

    def test_node_rejects_inconsistent_values(self) -> None:
        """A value that is in range, but inconsistent with others: only the node can reject it."""
        page, other = self.panelled(), self.panelled()
        before = rospy.get_param(NODE + "/multisine_amplitudes")
        self.set(page, "multisine_amplitudes", "[1.0, 2.0, 3.0]")
        refused = page.wait_for("refused")
        self.assertIn("three lists must have one length", refused["text"])
        reply = ("multisine_amplitudes", "[1.0, 0.5]")
        page.wait_for("value", lambda value: (value["name"], value["value"]) == reply)
        self.assertEqual(rospy.get_param(NODE + "/multisine_amplitudes"), before)
        self.assertEqual(other.messages("refused"), [])

    def test_number_with_a_comma_is_rejected_by_the_node(self) -> None:
        page = self.panelled()
        before = rospy.get_param(NODE + "/amplitude")
        self.set(page, "amplitude", "1,000")
        page.wait_for("refused", lambda reply: reply["name"] == "amplitude")
        self.assertEqual(rospy.get_param(NODE + "/amplitude"), before)

    def test_the_last_of_many_values_wins(self) -> None:
        page = self.panelled()
        self.restore("offset")
        for index in range(101):
            self.set(page, "offset", index / 100.0)
        wait_until(
            lambda: rospy.get_param(NODE + "/offset") == 1.0,
            lambda: rospy.get_param(NODE + "/offset"),
        )
        page.wait_for("value", lambda reply: (reply["name"], reply["value"]) == ("offset", 1.0))
        self.assertEqual(page.messages("refused"), [])

    def test_change_by_another_client_is_shown(self) -> None:
        page = self.panelled()
        self.restore("phase")
        rospy.set_param(NODE + "/phase", 0.75)
        page.wait_for("value", lambda reply: (reply["name"], reply["value"]) == ("phase", 0.75))
        page.forget()
        rospy.set_param(NODE + "/phase", "nonsense")  # the node restores it
        wait_until(lambda: rospy.get_param(NODE + "/phase") == 0.75, lambda: "not put back")
        self.assertNotIn("nonsense", str(page.messages("value")))

    def test_services_are_called(self) -> None:
        page = self.panelled()
        page.send("call", service=NODE + "/reset")
        called = page.wait_for("called")
        self.assertEqual((called["service"], called["success"]), (NODE + "/reset", True))
        self.assertIn("start at 0", called["message"])
        page.send("call", service=NODE + "/enable", data=False)
        page.wait_for("called", lambda reply: reply["service"] == NODE + "/enable")
        page.forget()
        page.send("call", service=NODE + "/enable", data=True)
        self.assertTrue(page.wait_for("called")["success"])

    def test_panel_is_removed_with_its_node(self) -> None:
        page = self.panelled()
        service = rospy.Service("/guest/describe", Trigger, describe_guest)
        page.wait_for(
            "panels", lambda reply: "/guest" in [panel["node"] for panel in reply["panels"]]
        )
        page.forget()
        service.shutdown("ended by the test")
        page.wait_for(
            "panels", lambda reply: "/guest" not in [panel["node"] for panel in reply["panels"]]
        )

    def test_a_change_while_a_panel_is_made_is_not_lost(self) -> None:
        page = self.panelled()
        self.restore("amplitude")
        rospy.set_param("/slow/a", 1)
        self.addCleanup(rospy.delete_param, "/slow")

        def describe(request: Any) -> Any:
            rospy.set_param("/slow/a", 2)
            # The master notifies a node of changes in order: when the scope has received
            # this one, it has received the previous one, without a description yet.
            rospy.set_param(NODE + "/amplitude", 3.5)
            page.wait_for(
                "value", lambda reply: (reply["name"], reply["value"]) == ("amplitude", 3.5)
            )
            return describe_guest(request)

        service = rospy.Service("/slow/describe", Trigger, describe)
        self.addCleanup(service.shutdown)
        page.wait_for("value", lambda reply: (reply["node"], reply["value"]) == ("/slow", 2))

    def test_invalid_description_has_no_panel(self) -> None:
        page = self.panelled()
        service = rospy.Service(
            "/babbler/describe", Trigger, lambda _: (True, "[!!python/object/new:os.system [id]]")
        )
        self.addCleanup(service.shutdown)
        guest = rospy.Service("/later/describe", Trigger, describe_guest)
        self.addCleanup(guest.shutdown)
        page.wait_for(
            "panels", lambda reply: "/later" in [panel["node"] for panel in reply["panels"]]
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
            reply = page.wait_for("managed", lambda reply: (node, state) in states(reply))
            return next(one for one in reply["nodes"] if one["node"] == node)["transitions"]

        def states(reply: Any) -> Any:
            return [(one["node"], one["state"]) for one in reply["nodes"]]

        self.assertEqual(wait_state("unconfigured"), ["configure", "shutdown"])
        page.send("transition", node=node, label="configure")
        self.assertEqual(sorted(wait_state("inactive")), ["activate", "cleanup", "shutdown"])
        page.send("transition", node=node, label="activate")
        wait_state("active")
        page.send("transition", node=node, label="configure")
        self.assertIn(f"{node} cannot configure now", page.wait_for("error")["text"])
        page.send("transition", node="/missing", label="configure")
        page.wait_for("error", lambda reply: "/missing cannot" in reply["text"])
        page.forget()
        talker.kill()  # the master still lists its services
        self.assertEqual(wait_state("does not answer"), [])
        page.send("transition", node=node, label="deactivate")
        page.wait_for("error", lambda reply: f"{node} cannot deactivate now" in reply["text"])
        page.forget()
        talker = subprocess.Popen(command)  # another node of its name, which ends cleanly
        self.addCleanup(talker.wait, 30.0)
        self.addCleanup(talker.terminate)
        self.assertEqual(wait_state("unconfigured"), ["configure", "shutdown"])
        page.forget()
        talker.terminate()
        page.wait_for("managed", lambda reply: states(reply) == [])

    def test_failing_managed_node_is_left_out_and_retried(self) -> None:
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
        # A page is notified of others nevertheless.
        self.assertNotIn("/unwell", str(self.page().wait_for("managed")))
