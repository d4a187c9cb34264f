"""The random controller's velocities and the simulator's own robot in a loop, without ROS."""

import math
from pathlib import Path
from typing import Set, Tuple

import pytest
import rospkg
import yaml

from bot_controller_demo.control.wandering import Wanderer
from diff_drive_sim.simulation.limits import RobotSettings
from diff_drive_sim.simulation.robot import Robot
from diff_drive_sim.simulation.world import World

#: The node's defaults.
LINEAR, ANGULAR, PERIOD = (0.1, 0.2), (-1.0, 1.0), 0.2
HOUR = 3600.0
#: Side of the squares that are counted as visited, m: about two robots wide.
CELL = 0.5


def arena() -> World:
    """Return the world of arena.yaml, 6 m square with three boxes."""
    folder = Path(rospkg.RosPack().get_path("diff_drive_sim"))
    return World(**yaml.safe_load((folder / "config" / "worlds" / "arena.yaml").read_text()))


def cells(world: World, radius: float) -> Set[Tuple[int, int]]:
    """Return the squares of the arena that a robot can stand in."""
    middles = [CELL * (number + 0.5) - 3.0 for number in range(int(6.0 / CELL))]
    return {
        (math.floor(x / CELL), math.floor(y / CELL))
        for x in middles
        for y in middles
        if world.distance(x, y) > radius and not inside_a_box(world, x, y)
    }


def inside_a_box(world: World, x: float, y: float) -> bool:
    """Return whether a line to the east crosses an odd number of walls besides the arena's own."""
    crossed = 0
    for x1, y1, x2, y2 in world.segments[4:]:
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            crossed += 1
    return crossed % 2 == 1


def test_in_an_hour_it_visits_the_arena() -> None:
    world, settings = arena(), RobotSettings()
    robot, wanderer = Robot(settings, world), Wanderer(1)
    visited, touches, stood_s, longest_s = set(), False, 0.0, 0.0
    for _ in range(int(HOUR / PERIOD)):
        robot.command(*wanderer.draw(LINEAR, ANGULAR, PERIOD, touches))
        touches = False
        before = robot.pose
        for _ in range(2):
            robot.step(0.5 * PERIOD)
            touches = touches or robot.touches
        visited.add((math.floor(robot.pose.x / CELL), math.floor(robot.pose.y / CELL)))
        stood_s = stood_s + PERIOD if (robot.pose.x, robot.pose.y) == before[:2] else 0.0
        longest_s = max(longest_s, stood_s)
    free = cells(world, settings.robot_radius)
    assert len(free) > 100
    assert len(visited & free) / len(free) > 0.95
    assert longest_s < 60.0


def test_no_turn_without_allowed_rate() -> None:
    wanderer = Wanderer(1)
    assert wanderer.draw((0.1, 0.1), (0.0, 0.0), PERIOD, True) == (0.1, 0.0)


@pytest.mark.parametrize("angular", [(-1.0, 0.5), (0.2, 0.9), (-0.7, 0.7)])
def test_at_a_wall_it_turns_by_a_quarter_to_half_a_turn(angular: Tuple[float, float]) -> None:
    wanderer = Wanderer(1)
    for _ in range(20):
        velocity = wanderer.draw(LINEAR, angular, 0.01, True)
        rate, turned = velocity.angular, 0.0
        assert abs(rate) == max(map(abs, angular))
        while velocity == (0.0, rate):
            turned += 0.01 * abs(rate)
            velocity = wanderer.draw(LINEAR, angular, 0.01, False)
        assert 0.5 * math.pi <= turned <= math.pi + 0.02
