"""Parameters that the launch files give to the nodes; no node is started."""

import functools
import os
from typing import Any, Dict, Type

import pytest
import rospkg
import yaml

from bot_controller_demo.nodes.proportional_controller import ProportionalControllerParameters
from bot_controller_demo.nodes.random_controller import RandomControllerParameters
from bot_controller_demo.nodes.teleop_keyboard import TeleopKeyboardParameters
from bot_controller_demo.nodes.waypoint_controller import WaypointControllerParameters
from nodekit import ParameterSet
from nodekit.testing.launch_files import load_launch, private_parameters

PACKAGES = rospkg.RosPack()
CONFIG = os.path.join(PACKAGES.get_path("bot_controller_demo"), "config")

load = functools.partial(load_launch, "bot_controller_demo")

DECLARED: Dict[str, Type[ParameterSet]] = {
    "proportional_controller": ProportionalControllerParameters,
    "random_controller": RandomControllerParameters,
    "teleop_keyboard": TeleopKeyboardParameters,
    "waypoint_controller": WaypointControllerParameters,
}
#: For each argument a value other than the default; its parameter has the same name.
DRIVING: Dict[str, Any] = {
    "controller_type": "gazebo",
    "control_law": "course",
    "kp_linear": 0.7,
    "kp_angular": 1.3,
    "linear_tolerance": 0.2,
    "angular_tolerance": 0.02,
    "control_frequency": 40.0,
    "max_linear_velocity": 0.2,
    "max_angular_velocity": 0.8,
    "odom_timeout": 0.3,
}
ARGUMENTS: Dict[str, Dict[str, Any]] = {
    "proportional_controller": {**DRIVING, "goal_x": -1.0, "goal_y": 3.0, "goal_theta": 0.5},
    "random_controller": {
        "controller_type": "gazebo",
        "linear_min": 0.05,
        "linear_max": 0.3,
        "angular_min": -2.0,
        "angular_max": 2.0,
        "timer_period_ms": 500,
        "seed": 7,
    },
    "teleop_keyboard": {"controller_type": "gazebo", "model": "waffle", "speed": 0.1, "turn": 0.5},
    "waypoint_controller": {**DRIVING, "repeat": True},
}
LAUNCH_FILES = [name + ".launch" for name in (*ARGUMENTS, "straight_line")]


@pytest.mark.parametrize("name, argument", [(n, a) for n in ARGUMENTS for a in ARGUMENTS[n]])
def test_each_argument_reaches_its_parameter_and_no_other(name: str, argument: str) -> None:
    """Omitted arguments have the node's defaults."""
    value = ARGUMENTS[name][argument]
    config = load(name + ".launch", f"{argument}:={value}")
    found = private_parameters(config, "/" + name)
    found.pop("waypoints", None)
    assert DECLARED[name](**found) == DECLARED[name](**{argument: value})


def test_straight_line_is_a_goal_straight_ahead() -> None:
    for argument, changed in (
        ("distance:=5.0", {}),
        ("distance:=3.0", {"goal_x": 3.0}),
        ("kp_linear:=0.7", {"kp_linear": 0.7}),
        ("controller_type:=gazebo", {"controller_type": "gazebo"}),
    ):
        config = load("straight_line.launch", argument)
        found = private_parameters(config, "/proportional_controller")
        expected = {"goal_x": 5.0, "goal_y": 0.0, "goal_theta": 0.0, **changed}
        parameters = ProportionalControllerParameters
        assert parameters(**found) == parameters(**expected), argument


def test_one_process_has_the_parameters_of_both() -> None:
    goal = {"goal_x": -1.0, "goal_y": 3.0, "goal_theta": 0.5, "controller_type": "gazebo"}
    arguments = [f"{name}:={value}" for name, value in goal.items()]
    config = load("one_process.launch", *arguments, "model:=waffle")
    assert [node.type for node in config.nodes] == ["host"]
    found = private_parameters(config, "/proportional_controller")
    assert ProportionalControllerParameters(**found) == ProportionalControllerParameters(**goal)
    robot = private_parameters(config, "/diff_drive")
    assert (robot["wheel_separation"], robot["controller_type"]) == (0.287, "gazebo")


def test_waypoints_are_those_of_a_file(tmp_path: Any) -> None:
    with open(os.path.join(CONFIG, "waypoints.yaml")) as file:
        points = yaml.safe_load(file)["waypoints"]
    own = tmp_path / "own.yaml"
    own.write_text("waypoints: [[1.0, 2.0]]")
    for arguments, expected in (((), points), ((f"waypoints_file:={own}",), [[1.0, 2.0]])):
        config = load("waypoint_controller.launch", *arguments)
        assert config.params["/waypoint_controller/waypoints"].value == expected
    assert len(WaypointControllerParameters(waypoints=points).goals) == 4


@pytest.mark.parametrize("name", LAUNCH_FILES)
def test_simulator_argument_starts_simulator_with_model_and_type(name: str) -> None:
    assert "diff_drive" not in [node.type for node in load(name).nodes]
    config = load(name, "simulator:=true", "model:=waffle", "controller_type:=gazebo")
    assert "diff_drive" in [node.type for node in config.nodes]
    robot = private_parameters(config, "/diff_drive")
    assert (robot["wheel_separation"], robot["controller_type"]) == (0.287, "gazebo")


def test_rviz_button_sends_goal_to_subscriber() -> None:
    path = os.path.join(PACKAGES.get_path("diff_drive_sim"), "rviz", "robot.rviz")
    with open(path) as file:
        tools = yaml.safe_load(file)["Visualization Manager"]["Tools"]
    (topic,) = [tool["Topic"] for tool in tools if tool["Class"] == "rviz/SetGoal"]
    (node,) = load("proportional_controller.launch").nodes
    assert topic == node.name + "/goal"
