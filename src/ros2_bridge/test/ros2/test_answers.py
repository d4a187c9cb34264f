"""Output of the ``ros2`` command line for a node of ROS 1, and for the same node in rclpy.

docs/ros2_answers.md shows both, and names each difference.
"""

import difflib
import os
import pathlib
import re
from typing import Dict, Iterator, List

import both
import pytest
from action_answers import ACTION, ROBOT
from action_parts import Server1
from answers import Answers
from domains import own_domain

from nodekit.testing.processes import Process

PAGE = both.SOURCES.parent / "docs" / "ros2_answers.md"
TWINS = pathlib.Path(__file__).with_name("twins_in_rclpy.py")


@pytest.fixture(scope="module")
def of_rclpy() -> Iterator[Dict[str, List[str]]]:
    """Return the answers of the twins, which run in their own domain."""
    domain = own_domain()
    # Without ROS 1's packages, whose messages would be imported.
    twins = Process(str(TWINS), [], {"ROS_DOMAIN_ID": str(domain), "PYTHONPATH": ""})
    answers = Answers(domain)
    try:
        answers.wait_for_nodes()
        yield answers.all()
    finally:
        answers.close()
        twins.end()


@pytest.fixture(scope="module")
def of_bridge(bridge: both.Bridge) -> Iterator[Dict[str, List[str]]]:
    """Return the answers of the same nodes of ROS 1."""
    answers = Answers(int(os.environ["ROS_DOMAIN_ID"]))
    with both.Running("basic_comms", "signal_generator.py") as generator:
        with both.Running("basic_comms", "process.py", "__name:=managed", "_managed:=true") as one:
            with Server1(ACTION, ROBOT[1:]):
                try:
                    answers.wait_for_nodes()
                    yield answers.all()
                finally:
                    answers.close()
            one.interrupt()
        generator.interrupt()


def compared(rclpy: List[str], bridge: List[str]) -> str:
    """Return the lines of both; where they differ, rclpy's follow with a minus."""
    lines = difflib.SequenceMatcher(None, rclpy, bridge, autojunk=False).get_opcodes()
    text = []
    for kind, first, last, start, end in lines:
        text += [f"  {line}" for line in rclpy[first:last]] if kind == "equal" else []
        text += [f"- {line}" for line in rclpy[first:last]] if kind != "equal" else []
        text += [f"+ {line}" for line in bridge[start:end]] if kind != "equal" else []
    return "\n".join(text)


def test_page_shows_answers_of_both(
    of_rclpy: Dict[str, List[str]], of_bridge: Dict[str, List[str]]
) -> None:
    assert len(of_rclpy) > 20 and list(of_rclpy) == list(of_bridge)
    now = {command: compared(of_rclpy[command], of_bridge[command]) for command in of_rclpy}
    shown = dict(
        re.findall(r"`(ros2 [^`]+)`\n\n```diff\n(.*?)\n```", PAGE.read_text("utf-8"), re.S)
    )
    for command, text in now.items():
        assert shown.get(command) == text, f"{command}: now\n{text}"
    assert list(shown) == list(now)
