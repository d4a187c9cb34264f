"""The directive ``{controller-plot} straight`` (or ``gains``, ``turn``): what a controller does.

The package's own goal controller drives the simulated robot, as the nodes do, with odometry that is
one sample old.
"""

from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Type

import matplotlib
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from bot_controller_demo.control import goal_controller
from bot_controller_demo.control.geometry import Goal, Pose
from bot_controller_demo.control.steering import Gains
from bot_controller_demo.control.straight_line import distance_left
from bot_controller_demo.control.velocities import MODELS, STOP, Limits, Velocity
from diff_drive_sim.simulation.limits import RobotSettings
from diff_drive_sim.simulation.robot import Robot

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

#: Where the plots are kept, below the folder of the pages.
FOLDER = "_generated"
PERIOD = 0.05
LIMITS, TOLERANCES = Limits(0.5, 1.0), (0.1, 0.05)
COLOURS = ("#2166ac", "#d6604d", "#1b7837", "#762a83")
GREY = "#999999"


class Seen(NamedTuple):
    """One sample of a run: time in s, where the robot is, and how far from its goal in m."""

    time: float
    pose: Pose
    distance: float


def drive(
    goal: Goal,
    seconds: float,
    law: str = "settling",
    gains: Gains = Gains(0.5, 1.0),
    first: Velocity = STOP,
    turn: Type[goal_controller.Turn] = goal_controller.Turn,
) -> List[Seen]:
    """Return what a burger does.

    :param goal: where to go from the origin
    :param seconds: for how long
    :param first: what it is doing when it is told
    :param turn: what keeps the direction of its turns
    """
    chase, robot, commands = goal_controller.GoalController(goal), Robot(RobotSettings()), [first]
    chase._heading = turn()
    tuning = goal_controller.Tuning(law, gains, LIMITS, *TOLERANCES)
    seen = []
    for number in range(round(seconds / PERIOD)):
        step = chase.step(Pose(*robot.odometry.pose), tuning)
        seen.append(Seen(number * PERIOD, Pose(*robot.odometry.pose), step.errors.distance))
        commands.append(step.velocity)
        robot.command(*commands.pop(0))
        robot.step(PERIOD)
    return seen


def straight(figure: Any) -> None:
    """Draw 5 m straight beside the closed form, and how far they are apart."""
    above, below = figure.subplots(2, sharex=True)
    limit = MODELS["burger"].linear
    seen = [one for one in drive(Goal(5.0, 0.0, 0.0), 26.0) if one.time >= PERIOD]
    # It begins to move with the command of the first sample, one sample later.
    times = [one.time - PERIOD for one in seen]
    exact = [max(distance_left(time, 5.0, 0.5, limit), 0.1) for time in times]
    above.plot(times, exact, color=GREY, linewidth=3.0, label="closed form")
    above.plot(times[::10], [one.distance for one in seen[::10]], ".", label="robot", c=COLOURS[0])
    free = [distance_left(time, 5.0, 0.5) for time in times]
    above.plot(times, free, "--", color=COLOURS[1], label="without a limit")
    above.set_ylabel("distance left, m")
    above.legend(frameon=False)
    errors = [1e3 * (one.distance - left) for one, left in zip(seen, exact)]
    below.plot(times, errors, color=COLOURS[0])
    below.set_ylabel("robot - closed form, mm")
    below.set_xlabel("time, s")


def gains(figure: Any) -> None:
    """Draw the distance for some linear gains, and paths for some angular ones."""
    left, right = figure.subplots(1, 2)
    for gain, colour in zip((0.25, 0.5, 1.0, 2.0), COLOURS):
        seen = drive(Goal(2.0, 0.0, 0.0), 16.0, gains=Gains(gain, 1.0))
        label = f"kp_linear {gain:g}"
        left.plot([s.time for s in seen], [s.distance for s in seen], color=colour, label=label)
    left.set_xlabel("time, s")
    left.set_ylabel("distance left, m")
    for gain, colour in zip((0.5, 1.0, 2.0), COLOURS):
        path = [s.pose for s in drive(Goal(0.0, 1.0, 0.0), 30.0, gains=Gains(0.5, gain))]
        label = f"kp_angular {gain:g}"
        right.plot([p.x for p in path], [p.y for p in path], color=colour, label=label)
    path = [s.pose for s in drive(Goal(0.0, 1.0, 0.0), 60.0, "course", Gains(0.5, 2.0))]
    label = "course's law, 2"
    right.plot([p.x for p in path], [p.y for p in path], color=GREY, linewidth=0.7, label=label)
    right.plot([0.0], [1.0], "k+", markersize=10)
    right.set_aspect("equal", adjustable="datalim")
    right.set_xlabel("x, m")
    right.set_ylabel("y, m")
    for axes in (left, right):
        axes.legend(frameon=False)


class _Forgetful(goal_controller.Turn):
    """Takes the short way at each sample."""

    def keep(self, error: float) -> float:
        return error


def turn(figure: Any) -> None:
    """Draw a turn by pi that keeps its direction, and one that does not."""
    axes = figure.subplots()
    for kind, label in ((goal_controller.Turn, "keeps its direction"), (_Forgetful, "does not")):
        seen = drive(Goal(0.0, 0.0, -3.13), 8.0, first=Velocity(0.0, 1.0), turn=kind)
        headings = [one.pose.theta for one in seen]
        colour = COLOURS[0] if kind is goal_controller.Turn else COLOURS[1]
        axes.plot([one.time for one in seen], headings, color=colour, label=label)
    axes.axhline(-3.13, color=GREY, linewidth=0.7)
    axes.set_xlabel("time, s")
    axes.set_ylabel("heading, rad")
    axes.legend(frameon=False)


#: What draws each plot, its size in inches, and what it shows.
PLOTS: Dict[str, Any] = {
    "straight": (straight, (7.0, 4.2), "distance left on 5 m straight, robot and closed form"),
    "gains": (gains, (7.0, 3.2), "distances for four linear gains, paths for three angular ones"),
    "turn": (turn, (7.0, 2.4), "heading in a turn by pi, keeping its direction and not"),
}


def draw(paint: Callable[[Any], None], size: Any, path: Path) -> None:
    """Make a picture.

    :param paint: draws into a figure
    :param size: of it, inches
    :param path: the file to write
    """
    plt.rcParams.update({"svg.hashsalt": "basic_comms", "font.size": 8})
    figure = plt.figure(figsize=size)
    paint(figure)
    for axes in figure.axes:
        axes.spines["top"].set_visible(False)
        axes.spines["right"].set_visible(False)
        axes.grid(color="#dddddd", linewidth=0.5)
    figure.tight_layout()
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


class ControllerPlot(SphinxDirective):
    """A plot of what a controller does."""

    required_arguments = 1

    def run(self) -> List[nodes.Node]:
        name = self.arguments[0]
        if name not in PLOTS:
            raise self.error(f"no plot {name!r}; there are {', '.join(PLOTS)}")
        paint, size, alt = PLOTS[name]
        picture = f"{FOLDER}/controller_{name}.svg"
        draw(paint, size, Path(self.env.srcdir, picture))
        return [nodes.image(uri="/" + picture, alt=alt)]


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("controller-plot", ControllerPlot)
    return {"parallel_read_safe": True}
