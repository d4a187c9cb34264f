#!/usr/bin/env python3
"""Descriptions by nodes: ~describe, the command describe, and dynamic_reconfigure."""

import math
import subprocess
import unittest
from typing import Any, Dict

import rospy
import yaml
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Log
from std_srvs.srv import Trigger

from basic_comms.conditioning.process_parameters import ProcessParameters
from basic_comms.signals.signal_parameters import SignalParameters
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until


def describe(*arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run the command describe."""
    command = ["rosrun", "basic_comms", "describe", *arguments]
    return subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True
    )


class Description(unittest.TestCase):
    """A generator at the root and a process in a group."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_description")
        for node in ("/generator", "/lab/process"):
            rospy.wait_for_service(node + "/set_parameters", TIMEOUT_S)

    def test_the_service_tells_value_type_unit_range_and_help(self) -> None:
        answer = rospy.ServiceProxy("/generator/describe", Trigger)()
        entries: Dict[str, Any] = {entry["name"]: entry for entry in yaml.safe_load(answer.message)}
        self.assertTrue(answer.success)
        self.assertEqual(list(entries), list(SignalParameters.declared))
        rate = entries["rate"]
        self.assertEqual(
            (rate["value"], rate["type"], rate["unit"], rate["range"], rate["default"]),
            (10.0, "float", "Hz", "[1e-06, 10000]", 10.0),
        )
        self.assertIn("samples", rate["help"])

    def test_the_command_describes_all_nodes_below_a_namespace(self) -> None:
        everything = describe("/")
        self.assertEqual(everything.returncode, 0, everything.stderr)
        for name in [*SignalParameters.declared, *ProcessParameters.declared]:
            self.assertRegex(everything.stdout, rf"(?m)^  {name} +=")
        group = describe("lab")
        self.assertEqual(group.returncode, 0, group.stderr)
        self.assertTrue(group.stdout.startswith("/lab/process\n"), group.stdout)
        self.assertNotIn("/generator", group.stdout)

    def test_the_command_prints_yaml_for_programs(self) -> None:
        entries = yaml.safe_load(describe("--yaml", "/lab/process").stdout)["/lab/process"]
        self.assertEqual([entry["name"] for entry in entries], list(ProcessParameters.declared))

    def test_the_command_says_what_there_is_instead(self) -> None:
        wrong = describe("/generater")
        self.assertEqual((wrong.returncode, wrong.stdout), (1, ""))
        self.assertIn("/generator", wrong.stderr)

    def test_reconfigure_and_rosparam_keep_one_truth(self) -> None:
        client = Client("/generator", timeout=30.0)

        def agree(value: float) -> None:
            wait_until(
                lambda: (
                    client.get_configuration(TIMEOUT_S)["amplitude"] == value
                    and rospy.get_param("/generator/amplitude") == value
                ),
                lambda: (
                    f"{client.get_configuration(TIMEOUT_S)} and {rospy.get_param('/generator')}, "
                    f"not {value}"
                ),
            )

        self.assertEqual(client.update_configuration({"amplitude": 3.0})["amplitude"], 3.0)
        agree(3.0)
        rospy.set_param("/generator/amplitude", 4.0)
        agree(4.0)
        self.assertEqual(client.update_configuration({"amplitude": 5.0})["amplitude"], 5.0)
        agree(5.0)
        client.close()

    def test_reconfigure_refuses_what_rosparam_refuses(self) -> None:
        client = Client("/generator", timeout=30.0)
        log = MessageRecorder("/rosout", Log)
        Graph().wait_until_heard("/generator", "/rosout", rospy.get_name())
        before = rospy.get_param("/generator")
        for name, bad in (("duty", math.nan), ("duty", 1.0), ("waveform", "triangel")):
            after = client.update_configuration({name: bad})
            self.assertEqual(after[name], before[name])
            log.wait_for(lambda line: f"/generator/{name}: " in line.msg and "refused" in line.msg)
            log.clear()
        self.assertEqual(rospy.get_param("/generator"), before)
        client.close()

    def test_reconfigure_knows_limits_and_words(self) -> None:
        client = Client("/generator", timeout=30.0)
        described = {entry["name"]: entry for entry in client.get_parameter_descriptions(30.0)}
        self.assertEqual((described["duty"]["min"], described["duty"]["max"]), (0.0, 1.0))
        self.assertEqual((described["seed"]["min"], described["seed"]["type"]), (0, "int"))
        self.assertIn("triangle", described["waveform"]["edit_method"])
        self.assertEqual(
            client.update_configuration({"waveform": "triangle"})["waveform"], "triangle"
        )
        client.close()


if __name__ == "__main__":
    rosrun("basic_comms", "description", Description)
