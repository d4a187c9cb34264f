"""Base class of tests with a simulated board behind the node, each in its own process."""

import os
import shutil
import tempfile
import time
import unittest
from typing import Any, Dict, List

import rospkg
from diagnostic_msgs.msg import DiagnosticArray
from pid_control.msg import motor_output

from nodekit.testing.changing import change
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.waiting import wait_until

SCRIPTS = os.path.join(rospkg.RosPack().get_path("serial_link"), "scripts")
#: How soon the board's messages come again [s], and what a busy machine may take on top: together
#: less than the 11 s after which a board notices by itself that the host is gone.
BACK_S, BUSY_S = 1.0, 6.0


class NodeRig(unittest.TestCase):
    """Each test has its own namespace, board and node."""

    def setUp(self) -> None:
        self.space = "/" + self.id().rsplit(".", 1)[-1]
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.port = os.path.join(self.folder, "by-id", "board")
        self.outputs = MessageRecorder(self.space + "/motor_output", motor_output)

    def start(self, name: str, *words: str, **parameters: Any) -> Process:
        """Start one of the nodes; it is stopped after the test."""
        given = [f"_{key}:={value}" for key, value in parameters.items()]
        script = os.path.join(SCRIPTS, name + ".py")
        process = Process(script, ["__ns:=" + self.space, *given, *words])
        self.addCleanup(process.end)
        return process

    def start_board(self, **parameters: Any) -> Process:
        return self.start("simulated_board", **{"link": self.port, "baud": 115200, **parameters})

    def start_link(self, *words: str, **parameters: Any) -> Process:
        return self.start(
            "serial_node", *words, **{"port": self.port, "baud": 115200, **parameters}
        )

    def start_both(self, **parameters: Any) -> Process:
        """Start both, and wait until the motor's speed is heard."""
        self.start_board(**parameters)
        link = self.start_link()
        self.outputs.wait_for(lambda heard: True)
        return link

    def set(self, **values: Any) -> None:
        """Do something to the board."""
        change(self.space + "/simulated_board", **values)

    def wait_until_back(self, since: float) -> None:
        """Wait for another message of the board, with a timeout."""
        self.outputs.clear()
        self.outputs.wait_for(lambda heard: True)
        self.assertLess(time.monotonic() - since, BACK_S + BUSY_S)

    def figures(self) -> Dict[str, int]:
        """Return the node's next figures."""
        name = self.space.lstrip("/") + "/serial_node: board"
        recorder = MessageRecorder("/diagnostics", DiagnosticArray)
        heard = recorder.wait_for(lambda message: message.status[0].name == name)
        recorder.close()
        return {entry.key: int(entry.value) for entry in heard.status[0].values}

    def wait_for_figure(self, name: str, least: int = 1) -> None:
        seen: List[Dict[str, int]] = []

        def is_there() -> bool:
            seen.append(self.figures())
            return seen[-1].get(name, 0) >= least

        wait_until(is_there, lambda: f"{name}: {seen[-1]}")
