"""Nodes of the launch files; no node is started."""

import os
from typing import List

import pytest
import rospkg

from nodekit.testing.launch_files import load_launch, node_names

LAUNCH = os.path.join(rospkg.RosPack().get_path("launch_files_demo"), "launch")
NAVIGATION = ["/camera_demo_node", "/lidar_demo_node"]


def nodes(name: str, *arguments: str) -> List[str]:
    """Return the names of the nodes that a launch file starts with these arguments."""
    config = load_launch("launch_files_demo", name, *arguments)
    assert all(node.output == "screen" for node in config.nodes)
    return node_names(config)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_there_are_three_ways_to_start_the_same_two_nodes(number: int) -> None:
    """Course 001-launch-1, 001-launch-2, 001-launch-3."""
    assert nodes(f"demo{number}.launch") == ["/listener", "/talker"]


def test_argument_enables_node() -> None:
    """Course 001-launch-4."""
    assert nodes("demo4.launch") == nodes("demo4.launch", "talker_arg:=false") == ["/listener"]
    assert nodes("demo4.launch", "talker_arg:=true") == ["/listener", "/talker"]


def test_a_group_is_started_with_a_node_outside_of_it() -> None:
    """Course 001-launch-5."""
    others = ["/processing_demo_node", "/temperature_demo_node"]
    assert nodes("demo5.launch") == sorted(NAVIGATION + others)


def test_argument_enables_group() -> None:
    """Course 001-launch-6, err-2."""
    assert nodes("demo6.launch") == ["/temperature_demo_node"]
    started = nodes("demo6.launch", "enable_nav_sensors:=true")
    assert started == [*NAVIGATION, "/temperature_demo_node"]
