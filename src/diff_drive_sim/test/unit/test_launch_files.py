"""What the launch files hand to the nodes; nothing is started here."""

import os
from typing import Any, Dict

import pytest
import rospkg
from roslaunch import RLException
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from diff_drive_sim.nodes.diff_drive_fleet import FleetParameters
from diff_drive_sim.robot_parameters import RobotParameters

LAUNCH = os.path.join(rospkg.RosPack().get_path("diff_drive_sim"), "launch")

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


def load(name: str, *arguments: str) -> ROSLaunchConfig:
    """Load a launch file as roslaunch does with these arguments."""
    config = ROSLaunchConfig()
    loader = XmlLoader()
    loader.ignore_unset_args = False
    loader.load(os.path.join(LAUNCH, name), config, argv=list(arguments), verbose=False)
    assert config.config_errors == []
    return config


def settings(config: ROSLaunchConfig, node: str = "/diff_drive") -> Dict[str, Any]:
    """Return the private parameters of a node by name, without ``managed``."""
    prefix = node + "/"
    values = {key: parameter.value for key, parameter in config.params.items()}
    values.pop(prefix + "managed", None)
    return {key[len(prefix) :]: values[key] for key in values if key.startswith(prefix)}


@pytest.mark.parametrize("argument", ROBOT)
def test_each_argument_of_a_robot_reaches_its_parameter(argument: str) -> None:
    name, value = ROBOT[argument]
    found = settings(load("diff_drive.launch", f"{argument}:={value}"))
    assert RobotParameters(**found) == RobotParameters(**{name: value})


@pytest.mark.parametrize("argument", FLEET)
def test_each_argument_of_a_fleet_reaches_its_parameter(argument: str) -> None:
    name, value = FLEET[argument]
    found = settings(load("fleet.launch", f"{argument}:={value}"), "/diff_drive_fleet")
    assert FleetParameters(**found) == FleetParameters(**{name: value})


@pytest.mark.parametrize("name", ["diff_drive.launch", "fleet.launch"])
def test_model_and_world_are_chosen_by_name_or_by_file(name: str) -> None:
    """Course 001-robot-1."""
    config = load(name, "model:=waffle", "world:=arena")
    (node,) = config.nodes
    found = settings(config, "/" + node.name)
    assert (found["wheel_separation"], len(found["walls"])) == (0.287, 4)
    world = os.path.join(LAUNCH, "..", "config", "worlds", "arena.yaml")
    model = os.path.join(LAUNCH, "..", "config", "models", "waffle.yaml")
    config = load(name, f"model_file:={model}", f"world_file:={world}")
    assert settings(config, "/" + node.name) == found


@pytest.mark.parametrize("name", ["diff_drive.launch", "fleet.launch"])
@pytest.mark.parametrize("choice", ["model", "world"])
def test_one_that_there_is_not_is_refused_by_its_name(name: str, choice: str) -> None:
    with pytest.raises(RLException, match=f"{choice}s/turtle.yaml"):
        load(name, f"{choice}:=turtle")


def test_managed_reaches_the_node() -> None:
    for text, is_managed in (("false", False), ("yes", True)):
        params = load("diff_drive.launch", f"managed:={text}").params
        assert params["/diff_drive/managed"].value is is_managed


def test_rviz_comes_only_when_asked_for() -> None:
    assert [node.type for node in load("diff_drive.launch").nodes] == ["diff_drive"]
    types = [node.type for node in load("diff_drive.launch", "rviz:=true").nodes]
    assert types == ["diff_drive", "robot_state_publisher", "rviz"]
