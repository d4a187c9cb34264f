"""Pages whose commands need ROS 2 show what readers see."""

import importlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
from typing import IO, Dict, NamedTuple, Optional

import both
import pytest
import rospy

from nodekit.testing.waiting import TIMEOUT_S, wait_until

WORKSPACE = both.SOURCES.parent
sys.path.append(str(WORKSPACE / "docs" / "tests"))
console_blocks = importlib.import_module("console_blocks")
job = importlib.import_module("job")
DOCS = WORKSPACE / "docs"


#: Warning of a node that the bridge asks for its parameters before the node has discovered the
#: bridge's side of that service: the bridge gets no answer, and asks later.
EARLY_QUESTION = re.compile(r"^.*RuntimeWarning: failed to send response.*\n.*\n", re.MULTILINE)


class Terminal(NamedTuple):
    """A running command, and its output."""

    popen: "subprocess.Popen[bytes]"
    output: IO[bytes]

    def printed(self) -> str:
        """Return all so far, apart from rclpy's warnings of early questions."""
        text = console_blocks.plain(pathlib.Path(self.output.name).read_text("utf-8"))
        return EARLY_QUESTION.sub("", text)


def start(command: str) -> Terminal:
    """Run a command; a ROS 2 command as through ./ci/ros2."""
    mine = command.replace("./ci/ros2 python3", f"env -u PYTHONPATH {sys.executable}")
    output = tempfile.NamedTemporaryFile()
    terminal = job.Terminal(pathlib.Path(output.name))
    with open(os.open(terminal.name, os.O_WRONLY | os.O_NOCTTY), "wb") as device:
        popen = subprocess.Popen(
            ["bash", "-c", f"exec {mine}"], cwd=str(WORKSPACE), stdout=device, stderr=device
        )
    terminal.follow()
    return Terminal(popen, output)


@pytest.mark.parametrize("page", ["ros2_bridge.md", "tutorials/robot_from_ros2.md"])
def test_page_shows_what_its_commands_print(ros: both.Both, page: str) -> None:
    rospy.set_param("/run_id", "tests")  # or each launch would give the master another one
    steps = console_blocks.instructions_of((DOCS / page).read_text("utf-8"))
    terminals: Dict[Optional[str], Terminal] = {}
    read: Dict[Optional[str], int] = {}
    try:
        for step in steps:
            if step.typed == console_blocks.INTERRUPT:
                terminals[step.terminal].popen.send_signal(signal.SIGINT)
                assert terminals[step.terminal].popen.wait(TIMEOUT_S) == 0, step
                continue
            if step.typed is not None:
                terminals[step.terminal], read[step.terminal] = start(step.typed), 0
            shown = terminals[step.terminal]
            if step.terminal is None:
                assert shown.popen.wait(2.0 * TIMEOUT_S) == 0, shown.printed()
                assert console_blocks.is_all(step.expected, shown.printed()), (
                    step,
                    shown.printed(),
                )
            else:
                read[step.terminal] = wait_until(
                    lambda: console_blocks.find(
                        step.expected, shown.printed(), read[step.terminal]
                    ),
                    lambda: f"{step}: {shown.printed()}",
                )
    finally:
        for terminal in terminals.values():
            if terminal.popen.poll() is None:
                terminal.popen.send_signal(signal.SIGINT)
                terminal.popen.wait(TIMEOUT_S)
    assert steps
