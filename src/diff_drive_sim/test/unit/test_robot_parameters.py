"""The parameters, and the files that set them."""

import os
from typing import Any

import pytest
import rospkg
import yaml

from diff_drive_sim.nodes.diff_drive_fleet import FleetParameters
from diff_drive_sim.robot_parameters import RobotParameters
from diff_drive_sim.simulation.limits import RobotSettings
from nodekit import ParameterError

CONFIG = os.path.join(rospkg.RosPack().get_path("diff_drive_sim"), "config")


def loaded(name: str) -> Any:
    """Return the parameters in a file of the package."""
    with open(os.path.join(CONFIG, name)) as file:
        return yaml.safe_load(file)


def test_robot_parameters_are_live_and_fleet_parameters_read_once() -> None:
    assert not any(each.read_once for each in RobotParameters.declared.values())
    assert all(each.read_once for each in FleetParameters.declared.values())
    assert FleetParameters(wheel_radius=0.05).wheel_radius == 0.05


def test_defaults_are_a_burger_s() -> None:
    assert RobotParameters().robot == RobotSettings()
    assert RobotParameters(**loaded("models/burger.yaml")) == RobotParameters()


@pytest.mark.parametrize("model", ["waffle", "waffle_pi"])
def test_waffles_are_as_turtlebot3_has_them(model: str) -> None:
    robot = RobotParameters(**loaded(f"models/{model}.yaml")).robot
    assert (robot.wheel_separation, robot.robot_radius) == (0.287, 0.220)
    assert (robot.max_linear_velocity, robot.max_angular_velocity) == (0.26, 1.82)


@pytest.mark.parametrize("world, walls", [("empty", 0), ("arena", 4 + 3 * 4)])
def test_initial_poses_are_free_in_all_worlds(world: str, walls: int) -> None:
    values = RobotParameters(**loaded(f"worlds/{world}.yaml"))
    assert len(values.world.segments) == walls
    assert values.world.distance(0.0, 0.0) > 1.0


@pytest.mark.parametrize(
    "walls", [[1.0, 2.0, 3.0, 4.0], [[1.0, 2.0, 3.0]], [[0, 0, 0, float("nan")]], "wall"]
)
def test_invalid_wall_is_rejected_with_message(walls: Any) -> None:
    with pytest.raises(ParameterError, match="walls: refused .* must be a list of 0 to 1000"):
        RobotParameters(walls=walls)


@pytest.mark.parametrize(
    "values, names, why",
    [
        ({"prefix": "a b"}, "prefix", "node name '/a b1/diff_drive': must be letters"),
        ({"prefix": "ä"}, "prefix", "must be letters"),
        ({"initial_x": 1e6}, "count", "initial_x: refused 1000001: must be"),
        ({"initial_y": 999_999.0, "count": 9}, "count", "initial_y: refused 1000001: must be"),
        ({"spacing": 1000.0, "initial_x": 999_000.5}, "spacing", "initial_x: refused 1000000.5"),
        ({"seed": 2**31 - 1}, "seed", "seed: refused 2147483648: must be"),
    ],
)
def test_fleet_rejects_values_invalid_for_a_robot(values: Any, names: str, why: str) -> None:
    with pytest.raises(ParameterError) as caught:
        FleetParameters(**values)
    assert names in caught.value.names
    assert why in str(caught.value)


def test_fleet_of_zero_or_one_starts_anywhere() -> None:
    for count in (0, 1):
        FleetParameters(count=count, initial_x=1e6, initial_y=1e6, seed=2**31 - 1)


def test_fleet_has_all_robot_parameters() -> None:
    assert set(RobotParameters.declared) < set(FleetParameters.declared)
