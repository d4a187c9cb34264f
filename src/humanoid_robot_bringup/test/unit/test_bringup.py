"""Nodes and parameters of the launch files; no node is started."""

import functools
import os
from typing import Any, Dict, Set

import pytest
import rospkg
import yaml

from bot_controller_demo.nodes.proportional_controller import ProportionalControllerParameters
from diff_drive_sim.robot_parameters import RobotParameters
from nodekit.testing.launch_files import load_launch

PACKAGE = rospkg.RosPack().get_path("humanoid_robot_bringup")
load = functools.partial(load_launch, "humanoid_robot_bringup", "robot.launch")
NAVIGATION, PERCEPTION = (
    {"proportional_controller"},
    {
        "camera_demo",
        "lidar_demo",
        "processing_demo",
    },
)


@pytest.mark.parametrize(
    "arguments, nodes",
    [
        ([], {"base"} | NAVIGATION | PERCEPTION),
        (["sim:=false"], NAVIGATION | PERCEPTION),
        (["perception:=off"], {"base"} | NAVIGATION),
        (["navigation:=no", "sim:=no"], PERCEPTION),
    ],
)
def test_parts_of_the_robot_are_switched(arguments: Any, nodes: Set[str]) -> None:
    """Courses 002-pkg-14, 004-bridge-9."""
    assert {node.name for node in load(*arguments).nodes} == nodes


def test_the_real_robot_s_drivers_are_a_launch_file(tmp_path: Any) -> None:
    drivers = tmp_path / "drivers.launch"
    drivers.write_text('<launch><node pkg="p" type="t" name="motors"/></launch>')
    found = {node.name for node in load("sim:=false", f"drivers:={drivers}").nodes}
    assert "motors" in found and "base" not in found


def config_of(name: str) -> Dict[str, Any]:
    with open(os.path.join(PACKAGE, "config", name)) as text:
        return dict(yaml.safe_load(text))


def test_configuration_is_loaded_and_allowed() -> None:
    """Course 002-pkg-15."""
    parameters = {key: value.value for key, value in load().params.items()}
    described = config_of("robot_description.yaml")
    assert described
    for name, value in described.items():
        assert parameters["/base/" + name] == value
    for file in ("controllers.yaml", "sensors.yaml"):
        nodes = config_of(file)
        assert nodes, file
        for node, values in nodes.items():
            for name, value in values.items():
                assert parameters[f"/{node}/{name}"] == value
    RobotParameters(**described)
    ProportionalControllerParameters(**config_of("controllers.yaml")["proportional_controller"])
