#!/usr/bin/env python3
"""Use the metronome as its users do: launch it, subscribe, set its parameters, press Ctrl-C."""

import unittest
from pathlib import Path

import rospy
import rostest
from nodekit.testing.graph import Graph
from nodekit.testing.launching import launched
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until
from std_msgs.msg import String

PROGRAM = str(Path(__file__).resolve().with_name("metronome.py"))


class MetronomeTest(unittest.TestCase):
    """Each test has its own metronome, in its own namespace."""

    def start(self, *arguments: str) -> Process:
        metronome = Process(PROGRAM, arguments)
        self.addCleanup(metronome.end)
        return metronome

    def test_it_takes_its_tempo_from_the_launch_file(self) -> None:
        with launched("metronome metronome.launch tempo:=90 __ns:=launch") as launch:
            launch.wait_until_up()
            launch.graph.wait_for_publishers("/launch/beat", "/launch/metronome")
            self.assertEqual(launch.graph.parameter("/launch/metronome/tempo"), 90)

    def test_a_change_takes_effect(self) -> None:
        graph, recorder = Graph(), MessageRecorder("/change/beat", String)
        self.start("__ns:=change", "_tempo:=400")
        recorder.wait_for(lambda message: message.data == "tick")
        graph.set_parameter("/change/metronome/sound", "tock")
        recorder.wait_for(lambda message: message.data == "tock")

    def test_an_invalid_value_is_refused_and_put_back(self) -> None:
        graph, metronome = Graph(), self.start("__ns:=nonsense")
        graph.wait_for_nodes("/nonsense/metronome")
        graph.wait_for_parameters("/nonsense/metronome", {"tempo": 120.0})
        graph.set_parameter("/nonsense/metronome/tempo", 1000)
        metronome.wait_for_log("WARN", "/nonsense/metronome/tempo", "[20, 400]")
        graph.wait_for_parameters("/nonsense/metronome", {"tempo": 120.0})

    def test_it_does_not_start_with_an_invalid_value(self) -> None:
        metronome = self.start("__ns:=fast", "_tempo:=fast")
        self.assertEqual(metronome.wait(), 1)
        self.assertTrue(metronome.logged("FATAL", "/fast/metronome/tempo", "'fast'"))

    def test_ctrl_c_ends_it_and_leaves_nothing_behind(self) -> None:
        graph, metronome = Graph(), self.start("__ns:=end")
        graph.wait_for_nodes("/end/metronome")
        self.assertEqual(metronome.interrupt(), 0)
        wait_until(lambda: not graph.nodes(), lambda: f"still there: {graph.nodes()}")


if __name__ == "__main__":
    rospy.init_node("test_metronome")
    rostest.rosrun("metronome", "metronome", MetronomeTest)
