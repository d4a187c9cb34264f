#!/usr/bin/env python3
"""What the documentation tells its readers to type does what it says."""

import signal
import unittest
from pathlib import Path
from typing import Callable

from helpers.tutorial import WORKSPACE, Reader

from nodekit.testing.console import instructions_of
from nodekit.testing.running import rosrun

#: Needs ROS 2: typed by a test of ros2_bridge.
IN_ROS2 = WORKSPACE / "docs" / "tutorials" / "robot_from_ros2.md"
PAGES = [WORKSPACE / "README.md", *sorted({*(WORKSPACE / "docs").rglob("*.md")} - {IN_ROS2})]


class Tutorials(unittest.TestCase):
    """One more test for each page with something to type is added below."""

    def test_every_tutorial_has_something_to_type(self) -> None:
        tutorials = [page for page in PAGES if page.parent.name == "tutorials"]
        silent = [page.stem for page in tutorials if not instructions_of(page.read_text())]
        self.assertEqual(silent, ["index"])


def _follows(page: Path) -> Callable[[unittest.TestCase], None]:
    def test(self: unittest.TestCase) -> None:
        with Reader() as reader:
            reader.follow(page.read_text())

    return test


for _page in PAGES:
    if instructions_of(_page.read_text()):
        # With its folder: docs and docs/tutorials have pages of the same name.
        _name = "_".join(_page.relative_to(WORKSPACE).with_suffix("").parts)
        setattr(Tutorials, f"test_{_name}", _follows(_page))

if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rosrun("basic_comms", "tutorials", Tutorials)
