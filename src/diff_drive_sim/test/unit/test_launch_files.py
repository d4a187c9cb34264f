"""Parameters that the launch files give to the nodes; no node is started."""

import functools
import os
from typing import Any, Dict

import pytest
import rospkg
from roslaunch import RLException

from diff_drive_sim.nodes.diff_drive_fleet import FleetParameters
from diff_drive_sim.robot_parameters import RobotParameters
from nodekit.testing.launch_files import load_launch, private_parameters

CONFIG = os.path.join(rospkg.RosPack().get_path("diff_drive_sim"), "config")

load = functools.partial(load_launch, "diff_drive_sim")

#: For each argument its parameter, and a value other than the default.
ROBOT: Dict[str, Any] = {
    "controller_type": ("controller_type", "gazebo"),
    "x": ("initial_x", 1.5),
    "y": ("initial_y", -2.0),
    "theta": ("initial_theta", 3.0),
    "publish_rate": ("publish_rate", 50.0),
    "command_timeout": ("command_timeout", 0.5),
    "max_wheel_acceleration": ("max_wheel_acceleration", 20.0),
    "odometry_noise": ("odometry_noise", 0.01),
    "seed": ("seed", 7),
    "scan_rate": ("scan_rate", 10.0),
    "frame_prefix": ("frame_prefix", "robot1/"),
    "publish_tf": ("publish_tf", False),
}
FLEET: Dict[str, Any] = {
    "count": ("count", 100),
    "prefix": ("prefix", "Group"),
    "spacing": ("spacing", 2.5),
    "controller_type": ("controller_type", "gazebo"),
    "scan_rate": ("scan_rate", 10.0),
}


@pytest.mark.parametrize("argument", ROBOT)
def test_each_argument_of_a_robot_reaches_its_parameter(argument: str) -> None:
    name, value = ROBOT[argument]
    found = private_parameters(load("diff_drive.launch", f"{argument}:={value}"), "/diff_drive")
    assert RobotParameters(**found) == RobotParameters(**{name: value})


@pytest.mark.parametrize("argument", FLEET)
def test_each_argument_of_a_fleet_reaches_its_parameter(argument: str) -> None:
    name, value = FLEET[argument]
    found = private_parameters(load("fleet.launch", f"{argument}:={value}"), "/diff_drive_fleet")
    assert FleetParameters(**found) == FleetParameters(**{name: value})


@pytest.mark.parametrize("name", ["diff_drive.launch", "fleet.launch"])
def test_model_and_world_are_chosen_by_name_or_by_file(name: str) -> None:
    """Course 001-robot-1."""
    config = load(name, "model:=waffle", "world:=arena")
    (node,) = config.nodes
    found = private_parameters(config, "/" + node.name)
    assert (found["wheel_separation"], len(found["walls"])) == (0.287, 4)
    world = os.path.join(CONFIG, "worlds", "arena.yaml")
    model = os.path.join(CONFIG, "models", "waffle.yaml")
    config = load(name, f"model_file:={model}", f"world_file:={world}")
    assert private_parameters(config, "/" + node.name) == found


@pytest.mark.parametrize("name", ["diff_drive.launch", "fleet.launch"])
@pytest.mark.parametrize("choice", ["model", "world"])
def test_missing_file_is_rejected_by_name(name: str, choice: str) -> None:
    with pytest.raises(RLException, match=f"{choice}s/turtle.yaml"):
        load(name, f"{choice}:=turtle")


def test_managed_reaches_the_node() -> None:
    for text, is_managed in (("false", False), ("yes", True)):
        params = load("diff_drive.launch", f"managed:={text}").params
        assert params["/diff_drive/managed"].value is is_managed


def test_rviz_starts_only_on_request() -> None:
    assert [node.type for node in load("diff_drive.launch").nodes] == ["diff_drive"]
    types = [node.type for node in load("diff_drive.launch", "rviz:=true").nodes]
    assert types == ["diff_drive", "robot_state_publisher", "rviz"]
