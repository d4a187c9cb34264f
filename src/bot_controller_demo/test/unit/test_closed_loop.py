"""The goal controller and the simulated robot in a loop, without ROS."""

import math
import random
from typing import List, NamedTuple, Optional

import pytest

from bot_controller_demo.control.geometry import Goal, Pose
from bot_controller_demo.control.goal_controller import ARRIVED, GoalController, Tuning
from bot_controller_demo.control.steering import Gains, may_circle
from bot_controller_demo.control.straight_line import distance_left, sampled, time_when
from bot_controller_demo.control.velocities import MODELS, STOP, Limits, Velocity
from diff_drive_sim.simulation.limits import RobotSettings
from diff_drive_sim.simulation.robot import Robot

PERIOD = 0.05
#: Defaults of the nodes.
LIMITS, TOLERANCES = Limits(0.5, 1.0), (0.1, 0.05)
UNLIMITED = Limits(100.0, 100.0)
#: The robots as they are by default, with the limits of their wheels.
ROBOTS = {
    "burger": RobotSettings(),
    "waffle": RobotSettings(0.287, 0.033, 0.220, 0.26, 1.82, 8.06),
}
#: Longest that any goal of these tests may take [s].
LONGEST_S = 120.0


def robot_of(limits: Limits) -> Robot:
    """Return a robot at the origin whose wheels have no limits.

    :param limits: of its velocities
    """
    settings = RobotSettings(
        max_linear_velocity=limits.linear,
        max_angular_velocity=limits.angular,
        max_wheel_speed=1e6,
    )
    return Robot(settings)


class Run(NamedTuple):
    """Course of a goal: distances and headings at each sample, path [m], and end [s]."""

    distances: List[float]
    headings: List[float]
    path: float
    settled_at: Optional[float]


def run(
    goal: Goal,
    robot: Robot,
    law: str = "settling",
    gains: Gains = Gains(0.5, 1.0),
    limits: Limits = LIMITS,
    delay: int = 1,
    longest: float = LONGEST_S,
    tolerance: float = TOLERANCES[0],
    first: Velocity = STOP,
) -> Run:
    """Drive to a goal.

    :param delay: age of a command when it takes effect, in samples
    :param longest: timeout [s]
    :param tolerance: distance at which the goal counts as reached [m]
    :param first: initial command of the robot
    """
    controller, commands = GoalController(goal), [first] * delay
    tuning = Tuning(law, gains, limits, tolerance, TOLERANCES[1])
    result = Run([], [], 0.0, None)
    path = 0.0
    for number in range(round(longest / PERIOD)):
        step = controller.step(Pose(*robot.odometry.pose), tuning)
        result.distances.append(step.errors.distance)
        result.headings.append(robot.odometry.pose.theta)
        if step.phase == ARRIVED and not any(robot.speeds):
            return result._replace(path=path, settled_at=number * PERIOD)
        commands.append(step.velocity)
        robot.command(*commands.pop(0))
        robot.step(PERIOD)
        path += abs(robot.speeds[0]) * PERIOD
    return result._replace(path=path)


def goals(count: int) -> List[Goal]:
    """Return random goals around the origin, always the same."""
    source = random.Random(18)
    return [
        Goal(source.uniform(-3, 3), source.uniform(-3, 3), source.uniform(-math.pi, math.pi))
        for _ in range(count)
    ]


@pytest.mark.parametrize("limit", [math.inf, *(MODELS[name].linear for name in MODELS)])
def test_five_metres_straight_are_the_sampled_recursion(limit: float) -> None:
    """Course 001-robot-8."""
    robot = robot_of(UNLIMITED)
    driven = run(Goal(5.0, 0.0, 0.0), robot, limits=Limits(min(limit, 100.0), 1.0), delay=0)
    assert driven.settled_at is not None and driven.distances[-1] <= 0.1
    moving = driven.distances[:-1]  # the last one is that of the robot at rest
    expected = sampled(5.0, 0.5, PERIOD, len(moving), limit)
    assert max(abs(a - b) for a, b in zip(moving, expected)) < 1e-9
    # Held for a period, the speed is on average half a period's loss too high.
    errors = [
        left - distance_left(number * PERIOD, 5.0, 0.5, limit) for number, left in enumerate(moving)
    ]
    assert max(map(abs, errors)) < 0.0625 * (1.0 if limit == math.inf else limit / 2.5)
    assert driven.settled_at == pytest.approx(time_when(0.1, 5.0, 0.5, limit), abs=0.15)


def test_closed_form_is_that_of_the_course() -> None:
    assert time_when(0.1, 5.0, 0.5) == pytest.approx(7.824, abs=1e-3)
    for model, knee, end in (("burger", 20.727, 23.69), ("waffle", 17.231, 20.53)):
        limit = MODELS[model].linear
        assert time_when(limit / 0.5, 5.0, 0.5, limit) == pytest.approx(knee, abs=1e-3)
        assert time_when(0.1, 5.0, 0.5, limit) == pytest.approx(end, abs=5e-3)
        for left in (4.9, limit / 0.5, 0.2, 0.1):
            moment = time_when(left, 5.0, 0.5, limit)
            assert distance_left(moment, 5.0, 0.5, limit) == pytest.approx(left)


@pytest.mark.parametrize("model", ["burger", "waffle"])
@pytest.mark.parametrize("acceleration", [0.0, 20.0])
def test_all_of_60_random_goals_are_reached_without_a_detour(
    model: str, acceleration: float
) -> None:
    """Course 001-robot-6."""
    settings = ROBOTS[model]._replace(max_wheel_acceleration=acceleration)
    for goal in goals(60):
        driven = run(goal, Robot(settings))
        assert driven.settled_at is not None, goal
        assert driven.distances[-1] <= 0.2 and driven.path <= 1.1 * math.hypot(goal.x, goal.y)


@pytest.mark.parametrize("scale", [0.1, 0.3, 3.0])
def test_near_and_far_goals_are_reached_without_a_detour(scale: float) -> None:
    for goal in goals(30):
        goal = goal._replace(x=scale * goal.x, y=scale * goal.y)
        driven = run(goal, robot_of(MODELS["burger"]), longest=400.0)
        assert driven.settled_at is not None, goal
        assert driven.path <= 1.1 * math.hypot(goal.x, goal.y)


@pytest.mark.parametrize(
    "linear, angular, tolerance, missed",
    [
        (0.5, 1.0, 0.1, 0),
        (0.25, 0.55, 0.1, 0),
        (0.5, 0.75, 0.1, 0),
        (2.0, 3.0, 0.1, 0),
        (2.0, 4.4, 0.1, 0),
        (0.5, 2.0, 0.1, 8),
        (0.5, 0.45, 0.1, 8),
        (2.0, 1.0, 0.1, 8),
        (0.25, 1.0, 0.1, 8),
        (8.0, 12.0, 0.1, 0),
        (0.5, 1.2, 0.1, 1),
        (0.5, 1.0, 0.05, 8),
    ],
)
def test_course_law_reaches_goals_unless_it_may_circle(
    linear: float, angular: float, tolerance: float, missed: int
) -> None:
    gains = Gains(linear, angular)
    runs = [
        run(goal, Robot(ROBOTS["burger"]), "course", gains, tolerance=tolerance)
        for goal in goals(20)
    ]
    count = len([one for one in runs if one.settled_at is None])
    assert may_circle(gains, tolerance) is (missed > 0)
    assert count >= missed if missed else count == 0


@pytest.mark.parametrize("theta", [math.pi, -math.pi, math.pi - 1e-9, 3.1, -3.1])
@pytest.mark.parametrize("delay", [0, 1, 4])
def test_a_turn_by_pi_keeps_its_direction_and_settles(theta: float, delay: int) -> None:
    robot = robot_of(MODELS["burger"])
    driven = run(Goal(0.0, 0.0, theta), robot, delay=delay, gains=Gains(0.5, 2.0))
    assert driven.settled_at is not None and driven.settled_at < 8.0
    turned = [b - a for a, b in zip(driven.headings, driven.headings[1:])]
    sides = {change > 0.0 for change in turned if 0.0 < abs(change) < 1.0}
    assert len(sides) == 1


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_robot_turning_the_other_way_still_turns(side: float) -> None:
    """It is just across when it is told, with one sample's delay; so it is at the next sample."""
    first = Velocity(0.0, side)
    driven = run(Goal(0.0, 0.0, -3.13 * side), robot_of(MODELS["burger"]), first=first)
    assert driven.settled_at is not None and driven.settled_at < 8.0


@pytest.mark.parametrize("y", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize("delay", [0, 1, 4])
def test_a_goal_behind_is_reached(y: float, delay: int) -> None:
    driven = run(Goal(-2.0, y, math.pi), robot_of(MODELS["waffle"]), delay=delay)
    assert driven.settled_at is not None and driven.settled_at < 25.0


def test_a_robot_that_shakes_about_pi_turns_all_the_same() -> None:
    """The measured heading is off by a little more than the robot turns in a sample."""
    controller = GoalController(Goal(0.0, 0.0, 0.0))
    tuning = Tuning("settling", Gains(0.5, 1.0), LIMITS, *TOLERANCES)
    heading, turned = math.pi, []
    for number in range(400):
        noise = 0.06 if number % 2 else -0.06
        step = controller.step(Pose(0.0, 0.0, math.remainder(heading + noise, math.tau)), tuning)
        turned.append(step.velocity.angular)
        heading += PERIOD * step.velocity.angular
    assert abs(math.remainder(heading, math.tau)) < 0.2
    assert len({rate > 0.0 for rate in turned[:40]}) == 1
