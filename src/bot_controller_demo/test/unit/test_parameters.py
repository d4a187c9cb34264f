"""Parameter declarations of the controllers."""

import math
from typing import Any, Dict, Type

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


@pytest.mark.parametrize(
    "declaration, defaults",
    [
        (
            RandomControllerParameters,
            {
                "controller_type": "rviz",
                "linear_min": 0.1,
                "linear_max": 0.2,
                "angular_min": -1.0,
                "angular_max": 1.0,
                "timer_period_ms": 200,
            },
        ),
        (
            ProportionalControllerParameters,
            {
                "controller_type": "rviz",
                "kp_linear": 0.5,
                "kp_angular": 1.0,
                "goal_x": 2.0,
                "goal_y": 1.0,
                "goal_theta": math.pi / 2.0,
                "linear_tolerance": 0.1,
                "angular_tolerance": 0.05,
                "control_frequency": 20.0,
                "max_linear_velocity": 0.5,
                "max_angular_velocity": 1.0,
            },
        ),
    ],
)
def test_names_and_defaults_are_the_course_s(
    declaration: Type[ParameterSet], defaults: Dict[str, Any]
) -> None:
    values = declaration()
    assert {name: getattr(values, name) for name in defaults} == defaults
