"""Base of the tests of a fleet and its monitor."""

import os
import unittest
from typing import Dict, List

import rospy
from std_srvs.srv import Trigger, TriggerResponse

from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
MONITOR = "/monitor"
#: Robots publish their status five times a second.
TIMES = ("_longest_period:=0.5", "_lost_after:=5")
#: The nodes that all tests share.
NODES: Dict[str, List[str]] = {
    "monitor": ["fleet_monitor", "_rate:=20", *TIMES, "_expected:=[one, ghost]"],
    "one": ["robot_monitor", "_robot_name:=one", "_period:=0.2"],
    "two": ["robot_monitor", "_robot_name:=two", "_period:=0.2"],
    "demo": ["robot_status_demo", "__ns:=in_one"],
}


def start(script: str, *arguments: str) -> Process:
    """Start a node or a command."""
    return Process(os.path.join(SCRIPTS, script), arguments)


def report(monitor: str = MONITOR) -> TriggerResponse:
    """Return how all are."""
    return rospy.ServiceProxy(f"{monitor}/report", Trigger)()


class MonitorRig(unittest.TestCase):
    """Has the nodes of :data:`NODES`, which all tests of a class share."""

    nodes: Dict[str, Process] = {}

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("tests_of_monitors")
        cls.nodes = {
            name: start(script, f"__name:={name}", *arguments)
            for name, (script, *arguments) in NODES.items()
        }
        for monitor in (MONITOR, "/in_one/fleet_monitor"):
            rospy.wait_for_service(f"{monitor}/report")

    @classmethod
    def tearDownClass(cls) -> None:
        for process in cls.nodes.values():
            process.end()

    @property
    def monitor(self) -> Process:
        """The process of the monitor."""
        return self.nodes["monitor"]

    def robot(self, name: str, *arguments: str) -> Process:
        process = start("robot_monitor", f"__name:={name}", *arguments)
        self.addCleanup(process.end)
        return process

    def wait_for_line(self, *words: str, monitor: str = MONITOR) -> None:
        """Wait for a line of the report that has these words."""

        def found() -> List[str]:
            lines = report(monitor).message.splitlines()
            return [line for line in lines if all(word in line for word in words)]

        wait_until(found, lambda: f"{words} in {report(monitor).message}")

    def wait_for_count(self, count: int, *words: str) -> None:
        """Wait until the monitor has logged a number of lines with these words."""
        wait_until(
            lambda: len(self.monitor.logged(*words)) >= count, lambda: str(self.monitor.lines[-20:])
        )
