"""Base of the tests of the panels."""

from typing import Any

import rospy
from wire.client import Client
from wire.signals_test import SignalsTest

NODE = "/signal_generator"


class ControlsTest(SignalsTest):
    """Test of a scope beside the course's nodes; each test restores their parameters."""

    def panelled(self) -> Client:
        """Return a page with the panels of both nodes."""
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
        """Restore a parameter at the end of the test."""
        self.addCleanup(rospy.set_param, f"{NODE}/{name}", rospy.get_param(NODE + "/" + name))


def describe_guest(_request: Any) -> Any:
    """Describe the one parameter of a node, as its service ``describe`` does."""
    return True, "- {name: a, value: 1, type: int, unit: '', range: '[0, 5]', help: ''}"
