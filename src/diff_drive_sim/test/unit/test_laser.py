"""Laser ranges, against distances that are known exactly."""

import math
from fractions import Fraction
from typing import List, Optional, Tuple

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from diff_drive_sim.messages.scanner import Scanner
from diff_drive_sim.robot_parameters import RobotParameters
from diff_drive_sim.simulation.kinematics import Pose
from diff_drive_sim.simulation.laser import Laser
from diff_drive_sim.simulation.world import World, box_corners

SQUARE = World([(2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2), (-2, -2, 2, -2)])
GRID = st.integers(-50, 50)


@pytest.mark.parametrize("rays", [1, 4, 8, 360, 1000])
def test_in_the_middle_of_a_square_each_ray_has_its_distance(rays: int) -> None:
    found = Laser(SQUARE.segments, rays).ranges(0.0, 0.0, 0.0)
    assert len(found) == rays
    for number, distance in enumerate(found):
        angle = 2.0 * math.pi * number / rays
        exact = 2.0 / max(abs(math.cos(angle)), abs(math.sin(angle)))
        assert distance == pytest.approx(exact, rel=1e-14), number


@given(st.floats(-1.9, 1.9), st.floats(-1.9, 1.9), st.floats(-math.pi, math.pi))
def test_from_anywhere_in_a_square_each_ray_ends_on_it(x: float, y: float, theta: float) -> None:
    found = Laser(SQUARE.segments, 90).ranges(x, y, theta)
    angles = theta + numpy.arange(90) * (2.0 * math.pi / 90)
    ends = numpy.maximum(abs(x + found * numpy.cos(angles)), abs(y + found * numpy.sin(angles)))
    # No ray passes through a corner.
    assert ends == pytest.approx(2.0, abs=1e-12)


def along_x(x: int, y: int, wall: Tuple[int, int, int, int]) -> Optional[Fraction]:
    """Return the exact distance from a point to a wall along x, None if the ray misses it."""
    x1, y1, x2, y2 = wall
    if y1 == y2 or not min(y1, y2) <= y <= max(y1, y2):
        return None
    met = x1 + Fraction(y - y1, y2 - y1) * (x2 - x1)
    return met - x if met >= x else None


@given(st.lists(st.tuples(GRID, GRID, GRID, GRID), max_size=20), GRID, GRID)
def test_nearest_of_any_walls_is_met_at_its_exact_distance(
    walls: List[Tuple[int, int, int, int]], x: int, y: int
) -> None:
    met = [distance for wall in walls for distance in [along_x(x, y, wall)] if distance is not None]
    found = Laser(walls, 1).ranges(x, y, 0.0)[0]
    assert found == pytest.approx(float(min(met)) if met else math.inf, rel=1e-12, abs=1e-12)


def test_a_turned_box_is_seen_as_its_four_walls() -> None:
    world = World(boxes=[(3.0, 0.0, 2.0, 1.0, math.pi / 2)])
    assert Laser(world.segments, 1).ranges(0.0, 0.0, 0.0)[0] == pytest.approx(2.5)
    assert sorted(box_corners(3.0, 0.0, 2.0, 1.0, math.pi / 2)) == [
        pytest.approx(corner) for corner in ((2.5, -1.0), (2.5, 1.0), (3.5, -1.0), (3.5, 1.0))
    ]


def test_empty_world_has_infinite_ranges() -> None:
    assert Laser([], 3).ranges(0.0, 0.0, 0.0).tolist() == [math.inf] * 3


def test_scan_uses_pose_and_range_of_laser() -> None:
    values = RobotParameters(scan_rate=10.0, scan_rays=4, laser_x=-0.032, scan_range=2.5)
    scan = Scanner(SQUARE, values, "base_scan").scan(Pose(0.5, 0.0, 0.0), "now")
    assert scan.ranges == [pytest.approx(1.532), pytest.approx(2.0), pytest.approx(2.468), 2.0]
    near = Scanner(SQUARE, values.replace(scan_range=2.0), "").scan(Pose(0.5, 0.0, 0.0), "now")
    assert near.ranges[2] == math.inf
    close = Scanner(SQUARE, values, "").scan(Pose(2.025, 0.0, 0.0), "now")
    assert close.ranges[0] == -math.inf
    assert scan.angle_max == pytest.approx(scan.angle_increment * 3)
    assert (scan.header.frame_id, scan.header.stamp, scan.scan_time) == ("base_scan", "now", 0.1)
