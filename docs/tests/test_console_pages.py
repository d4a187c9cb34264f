"""Consoles in the documentation show what readers see."""

from concurrent.futures import Future

import pytest
from console_blocks import instructions_of
from pages import texts_of_pages
from reader import Reader
from warm_python import WarmPython


#: Need ROS 2: typed by test_pages.py of ros2_bridge.
IN_ROS2 = ("docs/ros2_bridge.md", "docs/tutorials/robot_from_ros2.md")
PAGES = {page: text for page, text in texts_of_pages().items() if page not in IN_ROS2}
#: Beginnings of commands for which no process is forked, and why.
STARTED_ANEW = {
    "docs/tutorials/launch_demos.md": {
        "roslaunch basic_comms cw1.launch frequenzy": "nodekit looks for the command line of "
        "roslaunch in /proc, where a fork has that of the process it comes from"
    }
}


def effort(page: str) -> int:
    """Estimate how long a page takes."""
    typed = [instruction.typed or "" for instruction in instructions_of(PAGES[page])]
    return sum(10 if "launch" in command or "judge" in command else 1 for command in typed)


def type_page(page: str, python: WarmPython) -> None:
    """Do all that a page says."""
    with Reader(python=python, new_process=STARTED_ANEW.get(page, ())) as reader:
        reader.follow(PAGES[page])


@pytest.mark.parametrize("page", [page for page in PAGES if instructions_of(PAGES[page])])
def test_page_shows_what_its_commands_print(page: str, typed: "Future[None]") -> None:
    typed.result()


def test_every_tutorial_has_a_command() -> None:
    silent = [page for page in PAGES if not instructions_of(PAGES[page])]
    tutorials = [page for page in silent if page.startswith("docs/tutorials/")]
    assert tutorials == ["docs/tutorials/index.md"]


def test_command_that_is_new_process_is_still_there() -> None:
    assert STARTED_ANEW
    for page, starts in STARTED_ANEW.items():
        typed = [instruction.typed or "" for instruction in instructions_of(PAGES[page])]
        assert starts, page
        for start in starts:
            assert any(command.startswith(start) for command in typed), f"{page}: {start}"
