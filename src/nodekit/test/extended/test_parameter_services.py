#!/usr/bin/env python3
"""Tests of the services ~describe and ~change, and of their commands."""

import os
import subprocess
from typing import Any, Tuple

import rospkg
import rospy
import yaml
from helpers.parameter_node import GaugeParameters
from helpers.parameter_rig import ParameterCase, ParameterNode
from std_srvs.srv import Trigger

from nodekit.parameter_server.live_parameters import LiveParameters, open_all
from nodekit.parameter_server.parameter_services import change_handler
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.declaration import (
    FloatParameter,
    ListParameter,
    ParameterSet,
    rule,
    to_wire,
)
from nodekit.testing.processes import Server, hanging
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from nodekit_msgs.srv import SetParameters, SetParametersRequest

LAB = "/services/lab"
SCRIPTS = os.path.join(rospkg.RosPack().get_path("nodekit"), "scripts")
DEFAULTS = {name: to_wire(value) for name, value in GaugeParameters().as_dict().items()}


class PathParameters(ParameterSet):
    """Lists that are changed together or not at all."""

    xs = ListParameter([0.0], element=FloatParameter(0.0, help=""), help="corners")
    ys = ListParameter([0.0], element=FloatParameter(0.0, help=""), help="corners")

    @rule("xs", "ys")
    def as_many(self) -> None:
        """Keep one y for each x."""
        if len(self.xs) != len(self.ys):
            raise ValueError("there must be as many as of the other")


def command(*words: str) -> "subprocess.CompletedProcess[str]":
    """Run a command of nodekit; repeat it if a busy machine does not answer in time."""
    for _ in range(10):
        done = subprocess.run(
            [os.path.join(SCRIPTS, words[0]), *words[1:]],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )
        if "no answer within" not in done.stderr:
            break
    return done


class ParameterServices(ParameterCase):
    """Two nodes in one group; one name is a prefix of the other."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.server = Server()
        cls.nodes = [ParameterNode(f"{LAB}/{name}") for name in ("first", "first2")]
        for node in cls.nodes:
            rospy.wait_for_service(node.name + "/change", TIMEOUT_S)

    @classmethod
    def tearDownClass(cls) -> None:
        for node in cls.nodes:
            node.end()

    def setUp(self) -> None:
        self.node = self.nodes[0]
        self.change_service = rospy.ServiceProxy(self.node.name + "/change", SetParameters)
        # First what never was: the node's last report may be of before the last test's change.
        for values in ({**DEFAULTS, "title": self._testMethodName}, DEFAULTS):
            self.server.set(self.node.name, values)
            self.node.wait_for(**values)
        self.assert_truth(self.node, self.server)

    def change(self, text: str) -> Tuple[bool, str, Any]:
        """Call ~change; return the response."""
        answer = self.change_service(text)
        return answer.success, answer.message, yaml.safe_load(answer.values)

    def assert_refused(self, text: str, *words: str) -> None:
        """Call ~change, which must say why not and change nothing."""
        success, message, values = self.change(text)
        self.assertFalse(success, text)
        for word in words:
            self.assertIn(word, message)
        self.assertEqual(values, DEFAULTS)
        self.assert_truth(self.node, self.server)

    def test_several_parameters_change_together(self) -> None:
        before = self.node.changes
        success, message, values = self.change("{low: 20, high: 3e1, title: both, marks: [4]}")
        expected = {**DEFAULTS, "low": 20.0, "high": 30.0, "title": "both", "marks": [4.0]}
        self.assertEqual((success, message, values), (True, "", expected))
        self.node.wait_for(**expected)
        self.assert_truth(self.node, self.server)
        self.assertEqual(self.node.changes, before + 1)

    def test_one_refused_value_prevents_all_changes(self) -> None:
        name = self.node.name
        self.assert_refused("{count: 5, level: -1}", f"parameter {name}/level: refused -1: must")
        self.assert_refused("{level: -1, shape: square}", name + "/level: ", name + "/shape: ")
        self.assert_refused("{low: 20, count: 5}", f"{name}/low, {name}/high: refused 20, 10")
        self.assert_refused("{levle: 2, count: 5}", name + "/levle: ", "did you mean level?")

    def test_nonsense_is_answered_in_a_sentence(self) -> None:
        for text in ("[1, 2]", "5", "{", "level: [", "{[a]: 1}", "- " * 2000, "[" * 5000, "\0"):
            self.assert_refused(text, "malformed request: ")
        self.assert_refused("{" * 4000, "malformed request: ", "at most 20 deep")
        self.assert_refused(
            f"{{title: {'x' * 100_000}}}", "malformed request: 100009 characters: must be at most"
        )
        self.assert_refused("{level: 2000-99-99}", "malformed request: ")
        self.assert_refused("a: &a [*a]", "aliases")
        self.assert_refused("{1: 2}", "/1: ")
        self.assert_refused("{level: !!python/name:os.system }", "malformed request: ")
        for text in ('{level: !!int ""}', '{level: !!bool "x"}'):
            self.assert_refused(text, "malformed request: ")
        for text in (r"\x01", r"\ufffe"):
            self.assert_refused(f'{{title: "{text}"}}', f"{self.node.name}/title: refused ")

    def test_empty_change_returns_the_values(self) -> None:
        for text in ("", "{}"):
            self.assertEqual(self.change(text), (True, "", DEFAULTS))

    def test_lists_that_must_have_one_length_change_together(self) -> None:
        live = LiveParameters(PathParameters, "/services/path", get_watcher())
        self.addCleanup(live.close)
        open_all([live])
        answer = change_handler(live)
        for text, success in (
            ("{xs: [1, 2]}", False),
            ("{xs: [1, 2], ys: [3, 4]}", True),
            ("{xs: [1, 2, 3], ys: [3, 4]}", False),
        ):
            self.assertEqual(answer(SetParametersRequest(text)).success, success)
        self.assertEqual((live.values.xs, live.values.ys), ((1.0, 2.0), (3.0, 4.0)))
        self.assertEqual(self.server.get("/services/path"), {"xs": [1.0, 2.0], "ys": [3.0, 4.0]})

    def test_description_is_that_of_the_values_in_force(self) -> None:
        self.change("{level: 5}")
        entries = yaml.safe_load(
            rospy.ServiceProxy(self.node.name + "/describe", Trigger)().message
        )
        self.assertEqual([entry["name"] for entry in entries], list(DEFAULTS))
        self.assertEqual((entries[0]["value"], entries[0]["maximum"]), (5.0, 1e10))

    def test_command_change(self) -> None:
        done = command("change", self.node.name, "level", "5", "title", "on a shelf", "low", "-1e1")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        expected = {"level": 5.0, "title": "on a shelf", "low": -10.0}
        self.assertEqual(yaml.safe_load(done.stdout), expected)
        self.node.wait_for(**expected)
        for words, sentence in (
            ((self.node.name, "level", "-1"), "change: parameter %s/level: refused -1: must"),
            ((self.node.name + "s", "level", "1"), "there is %s"),
        ):
            wrong = command("change", *words)
            self.assertEqual((wrong.returncode, wrong.stdout), (1, ""))
            self.assertIn(sentence % self.node.name, wrong.stderr)

    def test_command_describe(self) -> None:
        done = command("describe", LAB)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for node in self.nodes:
            self.assertIn(node.name + "\n", done.stdout)
        self.assertRegex(done.stdout, r"(?m)^  level +=")
        entries = yaml.safe_load(command("describe", "--yaml", self.node.name).stdout)
        self.assertEqual(list(entries), [self.node.name])
        self.assertEqual([entry["name"] for entry in entries[self.node.name]], list(DEFAULTS))
        wrong = command("describe", self.node.name + "s")
        self.assertEqual((wrong.returncode, wrong.stdout), (1, ""))
        self.assertIn(self.node.name, wrong.stderr)

    def test_node_that_hangs_keeps_no_other_from_being_described(self) -> None:
        with hanging(self.node.popen.pid):
            for _ in range(10):
                # The last line says how long it has waited; a busy machine takes more to start.
                done = subprocess.run(
                    [os.path.join(SCRIPTS, "describe"), LAB],
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    universal_newlines=True,
                    timeout=TIMEOUT_S,
                )
                if f"{self.nodes[1].name} does not answer" not in done.stdout:
                    break  # else a busy machine has held that node up, too
            self.assertEqual(done.returncode, 1)
            lines, name = done.stdout.splitlines(), self.node.name
            self.assertEqual(lines[0], self.nodes[1].name, "the other has to wait for the first")
            silent = f"describe: {name} does not answer: {name}/describe: no answer within 2 s"
            self.assertEqual(lines[-1], silent)
            hung = command("change", self.node.name, "level", "2")
            self.assertEqual(hung.returncode, 1)
            self.assertIn("does not answer", hung.stderr)
        wait_until(lambda: self.change("{}")[0], lambda: "the node does not come back")


if __name__ == "__main__":
    rospy.init_node("parameter_services_test")
    rosrun("nodekit", "parameter_services", ParameterServices)
