#!/usr/bin/env python3
"""Tests of start, end and name of a node with live parameters, and of peers that hang."""

import contextlib
import itertools
import os
import signal
import socket
import tempfile
import threading
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from helpers.parameter_node import GaugeParameters
from helpers.parameter_rig import HELPERS, ParameterCase, Spy
from rosgraph.network import write_ros_handshake_header
from rospy.core import parse_rosrpc_uri

from nodekit.parameters.declaration import to_wire
from nodekit.testing.processes import Process, Server, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

DEFAULTS = {name: to_wire(value) for name, value in GaugeParameters().as_dict().items()}
TOO_LOW = "/level: refused -1: must be a number in [0, 1e+10] (V)"


class Life(ParameterCase):
    """Each test has its own nodes."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.server = Server()

    @contextmanager
    def burst_of_sets(self, key: str, count: int = 1000) -> Iterator[None]:
        """Set a value again and again from 0 to a count, as fast as the master allows."""
        end = threading.Event()

        def set_on() -> None:
            server = Server(self.server.uri)
            for level in itertools.cycle(range(count)):
                server.set(key, level)
                if end.is_set():
                    break

        thread = threading.Thread(target=set_on)
        thread.start()
        try:
            yield
        finally:
            end.set()
            thread.join()

    def assert_ended_well(self, node: Process, name: str, status: int) -> None:
        """Check the exit status, that nothing was raised and that no registration is left."""
        self.assertEqual(status, 0, node.error_lines)
        self.assertEqual(node.logged("Traceback"), [])
        self.assert_not_registered(name)

    def assert_not_registered(self, name: str) -> None:
        """Wait until the master, which may be busy, has processed the last request."""
        wait_until(lambda: not self.server.knows(name), lambda: f"{name} is still registered")

    def test_bad_values_at_the_start(self) -> None:
        self.server.set("/bad_value", {"level": -1})
        self.server.set("/bad_pair", {"low": 5, "high": 4})
        self.server.set("/bad_namespace", "text")
        for name, sentence in (
            ("/bad_value", "parameter /bad_value" + TOO_LOW),
            (
                "/bad_pair",
                "parameters /bad_pair/low, /bad_pair/high: refused 5, 4: low <= high",
            ),
            ("/bad_namespace", "parameter /bad_namespace: refused 'text': must be a name"),
        ):
            node = self.launch_node(name)
            self.assertEqual(node.wait(), 1)
            self.assertEqual(node.reports, [])
            (line,) = [line for line in node.error_lines if "waiting for the master" not in line]
            self.assertIn(sentence, line)
            self.assert_not_registered(name)
        self.assertEqual(self.server.get("/bad_value"), {"level": -1})

    def test_same_sentence_while_it_runs(self) -> None:
        node = self.start_node("/good_value")
        self.server.set("/good_value/level", -1)
        node.wait_for_log("WARN", "parameter /good_value" + TOO_LOW)

    def test_unset_parameters_are_written_at_the_start(self) -> None:
        self.server.set("/half_set", {"level": 5, "high": "1e3", "foreign": [1]})
        node = self.start_node("/half_set")
        values = {**DEFAULTS, "level": 5, "high": 1000.0}
        self.assertEqual(node.values, values)
        self.assertEqual(self.server.get("/half_set"), {**values, "foreign": [1]})
        self.assertIsInstance(self.server.get("/half_set/level"), int)
        node.wait_for_log("WARN", "/half_set/foreign is not used")
        self.server.set("/half_set/title", "was unset")
        node.wait_for(title="was unset")

    def test_values_set_while_it_starts(self) -> None:
        node = self.launch_node("/starting")
        for level in itertools.count():
            self.server.set("/starting/level", level)
            if node.logged("INFO", "/starting: level="):
                break
        node.wait_for(level=float(level))
        self.server.wait_for("/starting/level", level)

    def test_names_of_any_type_keep_their_values_apart(self) -> None:
        names = ["/lab/bench/probe", "/probe_1", "/probe_2", "/gauge_4711_1700000000000"]
        nodes = [self.launch_node(name) for name in names]
        for level, node in enumerate(nodes, start=2):
            wait_until(lambda: node.reports, lambda: f"start: {node.logged()}")
            self.server.set(node.name + "/level", level)
        for level, node in enumerate(nodes, start=2):
            node.wait_for(level=float(level))
            self.assertEqual(node.changes, 1)
        self.server.set("/lab/bench", {"probe": {"level": 7}})
        nodes[0].wait_for(level=7.0)

    def test_restarted_node_finds_its_values(self) -> None:
        node = self.start_node("/again")
        self.server.set("/again", {**DEFAULTS, "level": 5, "marks": []})
        node.wait_for(level=5.0, marks=[])
        self.assert_ended_well(node, "/again", node.interrupt())
        node = self.start_node("/again")
        self.assertEqual(node.values, {**DEFAULTS, "level": 5.0, "marks": []})
        self.server.set("/again/level", 6)
        node.wait_for(level=6.0)

    def test_interrupt_during_a_burst_of_sets(self) -> None:
        node = self.start_node("/bursting")
        with self.burst_of_sets("/bursting/level"):
            wait_until(lambda: node.changes >= 3, lambda: f"changes: {node.logged()}")
            self.assert_ended_well(node, "/bursting", node.interrupt())

    def test_interrupt_during_a_burst_of_refusals(self) -> None:
        node = self.start_node("/refusing")
        self.server.set("/refusing", {"low": 500.0, "high": 1000.0})
        node.wait_for(low=500.0, high=1000.0)
        with self.burst_of_sets("/refusing/high", 400):
            wait_until(lambda: node.logged("WARN"), lambda: f"warnings: {node.logged()}")
            self.assert_ended_well(node, "/refusing", node.interrupt())

    def test_interrupt_while_it_registers_services(self) -> None:
        node = Process(os.path.join(HELPERS, "parameter_slow_start.py"))
        self.addCleanup(node.end)
        node.wait_for_log("starting")
        self.assertEqual(node.interrupt(), 0)
        self.assertEqual(node.logged("Traceback"), [])

    def test_events_during_shutdown_cause_no_error(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        script = os.path.join(HELPERS, "late_events.py")
        node = Process(script, environment={"ROS_LOG_DIR": folder.name})
        self.addCleanup(node.end)
        wait_until(lambda: "/late_events/serve" in self.server.services(), lambda: "no service")
        uri = self.server.master.lookupService("/test", "/late_events/serve")[2]
        client = socket.create_connection(parse_rosrpc_uri(uri), TIMEOUT_S)
        self.addCleanup(client.close)
        asked = {"callerid": "/test", "service": "/late_events/serve", "md5sum": "*"}
        write_ros_handshake_header(client, asked)
        self.assertTrue(client.recv(1), "no answer")  # of the header: the request is waited for
        node.popen.send_signal(signal.SIGINT)
        wait_until(lambda: "ending" in node.lines, lambda: str(node.lines))
        client.close()
        self.assertEqual(node.wait(), 0)
        self.assertEqual(node.logged("ERROR"), [])
        (log,) = Path(folder.name).glob("late_events*.log")
        lines = log.read_text()
        self.assertRegex(lines, r"\[rosout\]\[WARNING\] .*: late\n")
        self.assertNotIn("ERROR", lines)

    def test_hung_subscribers_delay_no_other(self) -> None:
        node = self.start_node("/unhindered")
        hung = [Spy("/unhindered", "/blocked") for _ in range(3)]
        for spy in hung:
            self.addCleanup(spy.end)
        with contextlib.ExitStack() as waits:
            for spy in hung:
                waits.enter_context(hanging(spy.popen.pid))
            self.server.set("/blocked", 1)
            for level in (5, 6, 7):
                self.server.set("/unhindered/level", level)
                node.wait_for(level=float(level))
            self.server.set("/unhindered/level", -1)
            self.server.wait_for("/unhindered/level", 7.0)
            # Otherwise the delayed value could be a valid one that the reset has overwritten.
            self.server.set("/unhindered/level", 8)
            node.wait_for(level=8.0)
        # All that was held back arrives before this.
        self.server.set("/unhindered/title", "late")
        node.wait_for(title="late")
        wait_until(
            lambda: all(["/unhindered/title", "late"] in spy.updates for spy in hung),
            lambda: f"spies: {[spy.updates for spy in hung]}",
        )
        self.assert_truth(node, self.server)
        self.assertEqual((node.values["level"], node.changes), (8.0, 5))


if __name__ == "__main__":
    rosrun("nodekit", "live_parameters_life", Life)
