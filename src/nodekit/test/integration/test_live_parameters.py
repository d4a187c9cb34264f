#!/usr/bin/env python3
"""Tests of a running node's live parameters, with any tool and any value."""

import contextlib
import io
import tempfile
import urllib.request
import xmlrpc.client
from typing import Any, List

import rosparam
from helpers.parameter_rig import ParameterCase, ParameterNode, Spy

from nodekit.testing.processes import Server
from nodekit.testing.running import extended, rosrun
from nodekit.testing.waiting import wait_until

GAUGE = "/lab/gauge"
DEFAULTS = {
    "level": 1.0,
    "count": 3,
    "on": False,
    "title": "gauge",
    "shape": "round",
    "marks": [1.0, 2.0],
    "low": 0.0,
    "high": 10.0,
}

#: name, what the user types, value in force, value on the server afterwards
TAKEN = [
    ("level", "5", 5.0, 5),
    ("level", "5.5", 5.5, 5.5),
    ("level", "1e3", 1000.0, 1000.0),
    ("level", "'7'", 7.0, 7.0),
    ("level", "2147483648.0", 2147483648.0, 2147483648.0),
    ("level", "010", 8.0, 8),
    ("level", "1:30", 90.0, 90),
    ("count", "7", 7, 7),
    ("count", "8.0", 8, 8.0),
    ("count", "'9'", 9, 9),
    ("count", "2147483647", 2147483647, 2147483647),
    ("on", "true", True, True),
    ("on", "off", False, False),
    ("title", "hello world", "hello world", "hello world"),
    ("title", "", "", ""),
    ("title", "'1e3'", "1e3", "1e3"),
    ("shape", "flat", "flat", "flat"),
    ("marks", "[3, 4.5, '1e3']", [3.0, 4.5, 1000.0], [3.0, 4.5, 1000.0]),
    ("marks", "[]", [], []),
    ("low", "-5.0", -5.0, -5.0),
]

#: name, what the user types, how the warning shows it
REFUSED = [
    ("level", "off", "False"),
    ("level", "true", "True"),
    ("level", ".nan", "nan"),
    ("level", ".inf", "inf"),
    ("level", "", "''"),
    ("level", "high", "'high'"),
    ("level", "-0.1", "-0.1"),
    ("level", "2e10", "'2e10'"),
    ("level", "[1.0]", "[1.0]"),
    ("level", "{a: 1}", "{'a': 1}"),
    ("level", "!!binary aGk=", "b'hi'"),
    ("count", "0.5", "0.5"),
    ("count", "true", "True"),
    ("count", "2147483648.0", "2147483648"),
    ("count", "'2147483648'", "'2147483648'"),
    ("on", "1", "1"),
    ("on", "'true'", "'true'"),
    ("title", "5", "5"),
    ("title", "on", "True"),
    ("title", "{a: {b: c}}", "{'a': {'b': 'c'}}"),
    ("shape", "square", "'square'"),
    ("shape", "off", "False"),
    ("marks", "3", "3"),
    ("marks", "[1, a]", "[1, 'a']"),
    ("marks", "[1, .nan]", "[1, nan]"),
    ("low", "11", "11, 10"),
]


def run_rosparam(*arguments: str) -> None:
    """Run the command rosparam, in this process to save the time of its start."""
    with contextlib.redirect_stdout(io.StringIO()):
        rosparam.yamlmain(["rosparam", *arguments])


class LiveParameters(ParameterCase):
    """One long-lived node in a group namespace; each test starts with its defaults in force."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.server = Server()
        cls.node = ParameterNode(GAUGE)
        wait_until(lambda: cls.node.reports, lambda: f"start: {cls.node.logged()}")

    @classmethod
    def tearDownClass(cls) -> None:
        cls.node.end()

    def setUp(self) -> None:
        self.server.set(GAUGE, DEFAULTS)
        self.node.wait_for(**DEFAULTS)
        self.assert_truth(self.node, self.server)
        self.changes_before = self.node.changes
        self.logged_before = {word: len(self.node.logged(word)) for word in ("INFO", "WARN")}

    def new_log(self, level: str) -> List[str]:
        """Return the lines of a level that were logged in this test."""
        return self.node.logged(level)[self.logged_before[level] :]

    def assert_taken(self, **values: Any) -> None:
        """Wait for the values; nothing must have been refused."""
        self.node.wait_for(**values)
        self.assert_truth(self.node, self.server)
        self.assertEqual(self.new_log("WARN"), [])

    def assert_one_change(self, **values: Any) -> None:
        """Wait for the values, which must arrive in one call of the callback."""
        self.assert_taken(**values)
        self.assertEqual(self.node.changes, self.changes_before + 1)

    def test_values_that_are_taken(self) -> None:
        for name, typed, value, on_server in TAKEN:
            self.setUp()
            key = f"{GAUGE}/{name}"
            run_rosparam("set", key, typed)
            if value != DEFAULTS[name]:
                self.assert_one_change(**{name: value})
                (line,) = self.new_log("INFO")
                self.assertIn(key + ": ", line)
            self.server.wait_for(key, on_server)

    def test_values_that_are_refused(self) -> None:
        for name, typed, shown in REFUSED:
            self.setUp()
            key = f"{GAUGE}/{name}"
            run_rosparam("set", key, typed)
            wait_until(lambda: self.new_log("WARN"), lambda: f"warning of {key} {typed}")
            self.server.wait_for(key, DEFAULTS[name])
            (warning,) = self.new_log("WARN")
            for words in (key, f"refused {shown}: "):
                self.assertIn(words, warning)
            self.assertEqual(self.node.changes, self.changes_before, warning)

    def test_int_then_float_then_text(self) -> None:
        for value, on_server in ((5, 5), (5.5, 5.5), ("6", 6.0), ("x", 6.0), (7, 7)):
            self.server.set(GAUGE + "/level", value)
            self.server.wait_for(GAUGE + "/level", on_server)
            self.node.wait_for(level=float(on_server))

    def test_integer_of_64_bits_is_refused_though_it_hides_all_the_rest(self) -> None:
        # Clients in other languages can set values that the master cannot send.
        request = xmlrpc.client.dumps(("/test", GAUGE + "/level", 0), "setParam")
        request = request.replace("<int>0</int>", "<i8>2147483648</i8>")
        with urllib.request.urlopen(self.server.uri, request.encode()):
            pass
        self.server.set(GAUGE + "/count", 5)
        self.node.wait_for(count=5)
        self.node.wait_for_log(
            "WARN", GAUGE + "/level: refused a value that the master cannot send"
        )
        self.assert_truth(self.node, self.server)
        self.assertEqual(self.node.values, {**DEFAULTS, "count": 5})

    def test_loaded_file_is_validated_as_a_whole(self) -> None:
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write("{low: 20, high: 30, level: 1e1, marks: [7], title: loaded}")
            file.flush()
            run_rosparam("load", file.name, GAUGE)
        # Key by key, low would be above high.
        self.assert_taken(low=20.0, high=30.0, level=10.0, marks=[7.0], title="loaded")
        self.assertEqual(len(self.new_log("INFO")), 5)

    def test_namespace_is_set_and_keeps_the_rest(self) -> None:
        self.server.set(GAUGE + "/title", "kept")
        self.node.wait_for(title="kept")
        run_rosparam("set", GAUGE, "{low: 20, high: 30, shape: flat}")
        self.assert_taken(low=20.0, high=30.0, shape="flat", title="kept")

    def test_replaced_namespace_resets_the_rest_to_defaults(self) -> None:
        self.server.set(GAUGE + "/title", "gone")
        self.node.wait_for(title="gone")
        self.changes_before += 1
        self.server.set(GAUGE, {"count": 5, "on": True})
        self.assert_one_change(**{**DEFAULTS, "count": 5, "on": True})

    def test_group_namespace_is_replaced(self) -> None:
        self.server.set("/lab", {"gauge": {"level": 4.5}, "other": 1})
        self.assert_one_change(**{**DEFAULTS, "level": 4.5})
        self.assertEqual(self.server.get("/lab/other"), 1)

    def test_deleted_value_goes_back_to_its_default(self) -> None:
        self.server.set(GAUGE + "/level", 5.0)
        self.node.wait_for(level=5.0)
        self.changes_before += 1
        run_rosparam("delete", GAUGE + "/level")
        self.assert_one_change(level=1.0)
        self.server.wait_for(GAUGE + "/level", 1.0)

    def test_deleted_namespace_goes_back_to_the_defaults(self) -> None:
        self.server.set(GAUGE, {**DEFAULTS, "level": 5.0, "on": True, "marks": []})
        self.node.wait_for(level=5.0, on=True, marks=[])
        self.changes_before += 1
        run_rosparam("delete", GAUGE)
        self.assert_one_change(**DEFAULTS)

    def test_scalar_over_the_namespace_is_refused_and_all_values_are_restored(self) -> None:
        self.server.set(GAUGE, {**DEFAULTS, "level": 5.0, "someone_elses": "note"})
        self.node.wait_for(level=5.0)
        wait_until(lambda: self.new_log("WARN"), lambda: "a warning of the unknown name")
        self.server.set(GAUGE, 7)
        self.node.wait_for_log("WARN", f"parameter {GAUGE}: refused 7")
        self.server.wait_for(GAUGE + "/someone_elses", "note")
        self.assert_truth(self.node, self.server)
        self.assertEqual(self.node.values, {**DEFAULTS, "level": 5.0})
        self.assertEqual(self.node.changes, self.changes_before + 1)

    @extended
    def test_scalar_over_the_group_leaves_the_node_and_the_server_in_step(self) -> None:
        # Twice, since the first may be noticed because of an earlier notification.
        for note in (1, 2):
            self.server.set("/lab", note)
            wait_until(lambda: self.server.get("/lab") != note, lambda: "nothing is written")
            self.assert_truth(self.node, self.server)

    def test_trailing_slashes_are_ignored(self) -> None:
        self.server.set(GAUGE + "/level/", 5)
        self.assert_one_change(level=5.0)
        self.server.set(GAUGE + "/", {**DEFAULTS, "count": 5})
        self.node.wait_for(**{**DEFAULTS, "count": 5})

    def test_unknown_name_is_warned_of_once_with_the_nearest_one(self) -> None:
        run_rosparam("set", GAUGE + "/levle", "5")
        self.node.wait_for_log("WARN", GAUGE + "/levle is not used", "did you mean level?")
        for level in (2.0, 3.0):
            self.server.set(GAUGE + "/level", level)
            self.node.wait_for(level=level)
        self.assertEqual(len(self.node.logged("levle")), 1)
        self.assertEqual(self.server.get(GAUGE + "/levle"), 5)

    def test_broken_rule_reverts_its_two_parameters(self) -> None:
        self.server.set(GAUGE, {**DEFAULTS, "low": 20.0, "high": 15.0, "count": 4})
        self.node.wait_for(count=4)
        self.assert_truth(self.node, self.server)
        self.assertEqual(self.node.values, {**DEFAULTS, "count": 4})
        wait_until(lambda: self.new_log("WARN"), lambda: "there is no warning")
        (warning,) = self.new_log("WARN")
        self.assertIn(f"{GAUGE}/low, {GAUGE}/high: refused 20, 15", warning)
        self.assertIn("low <= high", warning)

    def test_node_sets_its_own_parameters(self) -> None:
        self.node.send(set_param={"~level": 6})
        self.assert_one_change(level=6.0)
        self.node.send(set_param={"~count": -1})
        self.node.wait_for_log("WARN", GAUGE + "/count: refused -1")
        self.server.wait_for(GAUGE + "/count", 3)

    def test_update_from_within_the_node_is_written(self) -> None:
        self.node.send(update={"level": "2e1", "low": 11, "high": 12})
        self.assert_one_change(level=20.0, low=11.0, high=12.0)
        self.node.send(update={"level": 30.0, "low": 13})
        self.node.wait_for_log("WARN", "update: parameter", "low <= high")
        self.assertEqual(self.node.values["level"], 20.0)
        self.assertEqual(self.server.get(GAUGE + "/level"), 20.0)

    def test_failing_listener_does_not_stop_changes(self) -> None:
        self.node.send(broken=True)
        self.node.send(set_param={"~level": 5})  # which it reads after that
        self.node.wait_for_log("ERROR", "a listener failed")
        self.assert_one_change(level=5.0)
        self.node.send(broken=False)
        self.server.set(GAUGE + "/level", 6)
        self.node.wait_for(level=6.0)

    @extended
    def test_node_writes_only_corrections(self) -> None:
        spy = Spy(GAUGE)
        self.addCleanup(spy.end)
        for level, held in ((2.0, 2.0), (3.0, 3.0), ("x", 3.0), (4.0, 4.0)):
            self.server.set(GAUGE + "/level", level)
            self.node.wait_for(level=held)
            self.server.wait_for(GAUGE + "/level", held)
        # The master does not notify it of values set in its own name: it has read again by then.
        for level in (5.0, 6.0):
            self.server.master.setParam(GAUGE, GAUGE + "/level", level)
            self.node.wait_for(level=level)
        expected = [[GAUGE + "/level", level] for level in (2.0, 3.0, "x", 3.0, 4.0, 5.0, 6.0)]
        wait_until(lambda: len(spy.updates) >= len(expected), lambda: str(spy.updates))
        self.assertEqual(spy.updates, expected)


if __name__ == "__main__":
    rosrun("nodekit", "live_parameters", LiveParameters)
