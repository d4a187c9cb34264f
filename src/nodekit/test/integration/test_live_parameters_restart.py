#!/usr/bin/env python3
"""A master that is killed and started again takes no value away."""

import signal

import rostest
from helpers.parameter_node import GaugeParameters
from helpers.parameter_rig import ParameterCase, ParameterNode

from nodekit.parameters.declaration import to_wire
from nodekit.testing.processes import Master, Server
from nodekit.testing.waiting import wait_until

DEFAULTS = {name: to_wire(value) for name, value in GaugeParameters().as_dict().items()}


class RestartedMaster(ParameterCase):
    """A master of the test's own."""

    def setUp(self) -> None:
        self.master = Master()
        self.addCleanup(lambda: self.master.kill())
        self.server = Server(self.master.uri)

    def start(self) -> ParameterNode:
        return self.start_node("/gauge", ROS_MASTER_URI=self.master.uri)

    def restart(self, node: ParameterNode) -> None:
        """Kill the master, have the node notice, and start another one."""
        self.master.kill()
        node.wait_for_log("WARN", "the master does not answer")
        self.master.start()
        self.server = Server(self.master.uri)

    def test_values_in_force_are_kept_and_written(self) -> None:
        node = self.start()
        self.server.set("/gauge", {**DEFAULTS, "level": 5, "title": "kept", "marks": []})
        node.wait_for(level=5.0, title="kept", marks=[])
        changes = node.changes
        self.restart(node)
        self.assert_truth(node, self.server)
        self.assertEqual(node.values, {**DEFAULTS, "level": 5.0, "title": "kept", "marks": []})
        self.assertEqual(node.changes, changes)
        node.wait_for_log("INFO", "the master answers again")
        self.assertEqual(len(node.logged("the master was restarted")), 1)
        self.assertEqual(len(node.logged("the master does not answer")), 1)
        wait_until(lambda: "/gauge/describe" in self.server.services(), self.server.services)

        self.server.set("/gauge/level", 6)
        node.wait_for(level=6.0)
        self.server.delete("/gauge/title")
        node.wait_for(title="gauge")
        self.assertEqual(node.interrupt(), 0)
        self.assertFalse(self.server.knows("/gauge"))

    def test_what_the_new_master_has_been_told_already_counts(self) -> None:
        node = self.start()
        self.server.set("/gauge", {**DEFAULTS, "level": 5, "title": "kept"})
        node.wait_for(level=5.0, title="kept")
        node.popen.send_signal(signal.SIGSTOP)
        self.master.kill()
        self.master.start()
        self.server = Server(self.master.uri)
        self.server.set("/gauge", {"level": 6, "count": -1})
        node.popen.send_signal(signal.SIGCONT)
        self.assert_truth(node, self.server)
        self.assertEqual(node.values, {**DEFAULTS, "level": 6.0, "title": "kept"})
        self.assertEqual(len(node.logged("WARN", "/gauge/count: -1 is refused")), 1)


if __name__ == "__main__":
    rostest.rosrun("nodekit", "live_parameters_restart", RestartedMaster)
