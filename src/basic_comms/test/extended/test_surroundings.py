#!/usr/bin/env python3
"""Nodes on a machine that is not in order: full disk, no log directory, no locale, wrong time."""

import os
import signal
import subprocess
import sys
import tempfile
import unittest
from typing import IO, Any, List, Optional, Tuple

import rospy
from roslib.packages import find_node
from std_msgs.msg import Float32, String

from basic_comms.msg import signal_msg
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: By node its program, its module and a topic that shows that it works.
NODES = {
    "/talker": ("talker.py", "/chatter", String),
    "/listener": ("listener.py", None, None),
    "/process": ("process.py", "/proc_signal", Float32),
    "/signal_generator": ("signal_generator.py", "/signal", signal_msg),
    "/fleet": ("fleet", "/Group1/proc_signal", Float32),
}
#: A process and the file of its stderr output.
Node = Tuple["subprocess.Popen[bytes]", IO[str]]
GREETING = "gr\u00fc\u00dfe \u4f60\u597d \U0001f916"
HOUR = 3600.0


class Surroundings(unittest.TestCase):
    """Each test starts its own nodes."""

    graph: Graph

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_surroundings")
        cls.graph = Graph()

    def start(
        self, *command: str, stdout: Any = subprocess.PIPE, **environment: Optional[str]
    ) -> Node:
        """Start a program; a variable that is None is unset."""
        merged = {**os.environ, **environment}
        errors = tempfile.TemporaryFile("w+")
        process = subprocess.Popen(
            command,
            env={name: value for name, value in merged.items() if value is not None},
            stdout=stdout,
            stderr=errors,
        )
        self.addCleanup(errors.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, errors

    def end(self, *nodes: Node) -> List[str]:
        """Interrupt nodes, check how they end and return the stderr output of each."""
        for process, _ in nodes:
            process.send_signal(signal.SIGINT)
        texts = []
        for process, errors in nodes:
            process.communicate(timeout=TIMEOUT_S)
            errors.seek(0)
            texts.append(errors.read())
            self.assertEqual(process.returncode, 0, texts[-1])
            self.assertNotIn("Traceback", texts[-1])
        return texts

    def recorder(self, topic: str, kind: Any) -> MessageRecorder:
        recorder = MessageRecorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def hear(self, recorder: MessageRecorder, count: int) -> None:
        """Wait for some more messages."""
        last = recorder.count() + count
        wait_until(lambda: recorder.count() >= last, lambda: f"heard {recorder.count()} of {last}")

    def test_full_disk_below_every_log(self) -> None:
        with tempfile.TemporaryDirectory() as logs, open("/dev/full", "w") as full:
            for name in NODES:
                os.symlink("/dev/full", os.path.join(logs, name[1:] + ".log"))
            nodes = [
                self.start(find_node("basic_comms", program)[0], stdout=full, ROS_LOG_DIR=logs)
                for program, _, _ in NODES.values()
            ]
            self.graph.wait_for_nodes(*NODES)
            recorders = [self.recorder(topic, kind) for _, topic, kind in NODES.values() if topic]
            for recorder in recorders:
                self.hear(recorder, 10)
            for errors in self.end(*nodes):
                self.assertEqual(errors.count("log lines are lost"), 1)

    def test_log_directory_that_cannot_be_written(self) -> None:
        for place in ({"ROS_LOG_DIR": "/proc"}, {"ROS_LOG_DIR": None, "ROS_HOME": "/proc"}):
            with self.subTest(place=place):
                node = self.start(find_node("basic_comms", "talker.py")[0], **place)
                chatter = self.recorder("/chatter", String)
                self.hear(chatter, 3)
                self.line_with(node[0], b"hello world")
                (errors,) = self.end(node)
                self.assertEqual(errors.count("WARNING: cannot"), 1)

    def test_console_that_is_closed(self) -> None:
        node = self.start(find_node("basic_comms", "talker.py")[0])
        chatter = self.recorder("/chatter", String)
        self.hear(chatter, 3)
        node[0].stdout.close()
        self.hear(chatter, 10)
        node[0].stdout = None
        self.assertIn("Broken pipe", self.end(node)[0])

    def test_no_locale_and_any_characters(self) -> None:
        rospy.set_param("/Message", GREETING)
        self.addCleanup(rospy.delete_param, "/Message")
        nowhere = {"LC_ALL": "C", "LANG": None, "LC_CTYPE": None, "LANGUAGE": None}
        ascii_only = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
        escaped = GREETING.encode("ascii", "backslashreplace")
        for settings, seen in (({}, GREETING.encode()), (ascii_only, escaped)):
            with self.subTest(settings=settings):
                nodes = [
                    self.start(find_node("basic_comms", program)[0], **nowhere, **settings)
                    for program in ("listener.py", "talker.py")
                ]
                chatter = self.recorder("/chatter", String)
                chatter.wait_for(lambda message: message.data.startswith(GREETING))
                line = self.line_with(nodes[0][0], b"I heard")
                self.assertIn(b"'%s " % seen, line)
                self.end(*nodes)
                chatter.close()

    def line_with(self, process: Any, words: bytes) -> bytes:
        """Read on to a line of a node's log with some words."""
        line: bytes = next(line for line in process.stdout if words in line)
        return line

    def test_wall_clock_that_is_set(self) -> None:
        talker, generator = (
            self.start(
                sys.executable,
                "-m",
                "nodekit.testing.stepping_clock",
                "basic_comms.nodes." + name,
                stdout=subprocess.DEVNULL,
            )
            for name in ("talker", "signal_generator")
        )
        chatter, samples = self.recorder("/chatter", String), self.recorder("/signal", signal_msg)
        self.hear(chatter, 3)
        self.hear(samples, 3)
        back, ahead = signal.SIGUSR1, signal.SIGUSR2
        for number, shift in ((back, -HOUR), (ahead, 0.0), (ahead, HOUR)):
            chatter.clear()
            for process, _ in (talker, generator):
                process.send_signal(number)
            chatter.wait_for(lambda message: abs(late(message) - shift) < HOUR / 10.0)
            self.hear(samples, 10)
        rospy.set_param("/signal_generator/amplitude", 7.0)
        samples.wait_for(lambda sample: sample.amplitude == 7.0)
        times = [sample.time_x for sample in samples.messages()]
        steps = [later - one for one, later in zip(times, times[1:])]
        self.assertEqual({round(step, 6) for step in steps}, {0.1})
        self.end(talker, generator)


def late(message: String) -> float:
    """Return how far ahead of this process's clock the talker's is [s]."""
    return float(message.data.split()[-1]) - rospy.get_time()


if __name__ == "__main__":
    rosrun("basic_comms", "surroundings", Surroundings)
