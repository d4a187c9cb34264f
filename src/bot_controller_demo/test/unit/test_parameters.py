"""What the declarations of the controllers say of their parameters."""

from typing import Type

import pytest

from bot_controller_demo.nodes.proportional_controller import ProportionalControllerParameters
from bot_controller_demo.nodes.random_controller import RandomControllerParameters
from bot_controller_demo.nodes.teleop_keyboard import TeleopKeyboardParameters
from bot_controller_demo.nodes.waypoint_controller import WaypointControllerParameters
from nodekit import ParameterSet


@pytest.mark.parametrize(
    "declaration",
    [
        ProportionalControllerParameters,
        WaypointControllerParameters,
        RandomControllerParameters,
        TeleopKeyboardParameters,
    ],
)
def test_only_the_type_of_the_commands_is_read_once(declaration: Type[ParameterSet]) -> None:
    marked = [name for name, each in declaration.declared.items() if each.read_once]
    assert marked == ["controller_type"]
