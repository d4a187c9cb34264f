"""Which point comes next; what drives there is another test's."""

from typing import Any, List

import pytest

from bot_controller_demo.geometry import Goal
from bot_controller_demo.nodes import waypoint_controller
from bot_controller_demo.nodes.waypoint_controller import (
    WaypointController,
    WaypointControllerParameters,
)
from bot_controller_demo_msgs.msg import Progress


class FakeNode:
    """Takes what a node is given, and stands for its driver, which is there at each step."""

    def __init__(self, values: WaypointControllerParameters) -> None:
        self.values = values
        self.tick: Any = None
        self.goals: List[Goal] = []

    def parameters(self, declaration: Any, on_change: Any) -> "FakeNode":
        return self

    def every(self, rate: Any, callback: Any) -> None:
        self.tick = callback

    def head_for(self, goal: Goal) -> None:
        self.goals.append(goal)

    def step(self) -> Progress:
        return Progress(phase=Progress.ARRIVED)


def goals(monkeypatch: "pytest.MonkeyPatch", steps: int, **values: Any) -> List[Goal]:
    """Return where a controller heads for."""
    node: Any = FakeNode(WaypointControllerParameters(**values))
    monkeypatch.setattr(waypoint_controller, "Driver", lambda node, parameters: node)
    WaypointController(node)
    for _ in range(steps):
        node.tick(0.0)
    return list(node.goals)


ONE, TWO = [1.0, 0.0], [2.0, 0.0, 3.0]


def test_points_are_gone_through_once_or_again_and_again(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    one, two = Goal(*ONE), Goal(*TWO)
    assert goals(monkeypatch, 3, waypoints=[ONE, TWO]) == [one, two]
    assert goals(monkeypatch, 3, waypoints=[ONE, TWO], repeat=True) == [one, two, one, two]


def test_a_single_point_is_gone_to_once_and_not_at_each_step(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    assert goals(monkeypatch, 5, waypoints=[ONE], repeat=True) == [Goal(*ONE)]
    assert goals(monkeypatch, 5, waypoints=[ONE, ONE], repeat=True) == 2 * [Goal(*ONE)]


def test_without_points_it_goes_nowhere(monkeypatch: "pytest.MonkeyPatch") -> None:
    assert goals(monkeypatch, 3, waypoints=[], repeat=True) == []
