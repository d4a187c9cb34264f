"""Order of the waypoints; other tests cover the driving."""

import math
from typing import Any, List, Optional

import pytest

from bot_controller_demo.control.geometry import Goal
from bot_controller_demo.nodes import waypoint_controller
from bot_controller_demo.nodes.waypoint_controller import (
    WaypointController,
    WaypointControllerParameters,
)
from bot_controller_demo_msgs.msg import Progress


class FakeNode:
    """Fake node and driver, which needs one step to each point."""

    def __init__(self, values: WaypointControllerParameters) -> None:
        self.values = values
        self.tick: Any = None
        self.goals: List[Goal] = []
        self.at = Goal(0.0, 0.0)

    def declare_parameters(self, declaration: Any, on_change: Any) -> "FakeNode":
        return self

    def create_timer(self, rate: Any, callback: Any) -> None:
        self.tick = callback

    def head_for(self, goal: Goal) -> None:
        self.goals.append(goal)

    def step(self) -> Optional[Progress]:
        if not self.goals:
            return None
        goal = self.goals[-1]
        if math.hypot(goal.x - self.at.x, goal.y - self.at.y) > self.values.linear_tolerance:
            self.at = goal
            return Progress(phase=Progress.DRIVING)
        return Progress(phase=Progress.ARRIVED)


def goals(monkeypatch: "pytest.MonkeyPatch", steps: int, **values: Any) -> List[Goal]:
    """Return the goal of a controller."""
    node: Any = FakeNode(WaypointControllerParameters(**values))
    monkeypatch.setattr(waypoint_controller, "Driver", lambda node, parameters: node)
    WaypointController(node)
    for _ in range(steps):
        node.tick(0.0)
    return list(node.goals)


ONE, TWO = [1.0, 0.0], [2.0, 0.0, 3.0]


def test_waypoints_are_visited_once_or_repeatedly(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    one, two = Goal(*ONE), Goal(*TWO)
    assert goals(monkeypatch, 9, waypoints=[ONE, TWO]) == [one, two]
    assert goals(monkeypatch, 6, waypoints=[ONE, TWO], repeat=True) == [one, two, one, two]


def test_robot_at_all_points_does_not_restart_each_step(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    near = [1.05, 0.0]
    assert goals(monkeypatch, 9, waypoints=[ONE], repeat=True) == 2 * [Goal(*ONE)]
    found = goals(monkeypatch, 20, waypoints=[ONE, near], repeat=True)
    assert found == 2 * [Goal(*ONE), Goal(*near)]


def test_without_points_it_goes_nowhere(monkeypatch: "pytest.MonkeyPatch") -> None:
    assert goals(monkeypatch, 3, waypoints=[], repeat=True) == []
