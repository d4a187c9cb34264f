"""The directive ``{drive-plot} NAME``: runs of the very robot that diff_drive simulates.

``paths`` shows where pairs of wheel speeds lead, ``methods`` how far other ways to integrate are
off, ``odometry`` where robots with noise believe to be, and what their covariance says.
"""

import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

import matplotlib
import numpy
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from diff_drive_sim.simulation.kinematics import Pose, Wheels, body_speeds
from diff_drive_sim.simulation.limits import RobotSettings
from diff_drive_sim.simulation.robot import Robot

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

#: Where the plots are kept, below the folder of the pages.
FOLDER = "_generated"
COLOURS = ("#2166ac", "#d6604d", "#4d9221", "#984ea3")
BURGER = RobotSettings(command_timeout=0.0)
RATE = 30.0


def paths(figure: Any) -> str:
    """Draw where some pairs of wheel speeds lead in 6 s."""
    axes = figure.add_subplot()
    pairs = ((5.0, 5.0), (4.0, 6.0), (2.0, 6.0), (-3.0, 3.0))
    for wheels, colour in zip(pairs, COLOURS):
        robot = Robot(BURGER)
        robot.command(*body_speeds(Wheels(*wheels), BURGER.wheel_separation, BURGER.wheel_radius))
        run = [robot.pose]
        for _ in range(180):
            robot.step(1.0 / RATE)
            run.append(robot.pose)
        linear, angular = robot.speeds
        label = "wheels %g, %g rad/s: v = %.3f m/s, ω = %.2f rad/s" % (*wheels, linear, angular)
        axes.plot([p.x for p in run], [p.y for p in run], color=colour, label=label)
        for side in (-0.5, 0.5):
            half = side * BURGER.wheel_separation
            axes.plot(
                [p.x - half * math.sin(p.theta) for p in run],
                [p.y + half * math.cos(p.theta) for p in run],
                linestyle=":",
                color=colour,
                linewidth=0.8,
            )
        axes.plot(run[-1].x, run[-1].y, "o", color=colour, markersize=4)
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    return "paths of the robot and of its wheels for four pairs of wheel speeds"


def _euler(pose: Pose, distance: float, turn: float) -> Pose:
    return Pose(
        pose.x + distance * math.cos(pose.theta),
        pose.y + distance * math.sin(pose.theta),
        pose.theta + turn,
    )


def _midpoint(pose: Pose, distance: float, turn: float) -> Pose:
    direction = pose.theta + 0.5 * turn
    return Pose(
        pose.x + distance * math.cos(direction),
        pose.y + distance * math.sin(direction),
        pose.theta + turn,
    )


def _single(pose: Pose, distance: float, turn: float) -> Pose:
    return Pose(*map(float, map(numpy.float32, _midpoint(pose, distance, turn))))


def methods(figure: Any) -> str:
    """Draw how far ways to integrate are off, at 0.22 m/s and 1 rad/s."""
    linear, angular, seconds = 0.22, 1.0, 100.0
    steps: Dict[str, Callable[[Pose, float, float], Pose]] = {
        "forward Euler": _euler,
        "midpoint, numbers of 32 bits": _single,
        "midpoint": _midpoint,
        "exact arc": Pose.moved,
    }
    axes = figure.add_subplot()
    for (name, step), colour in zip(steps.items(), COLOURS[::-1]):
        pose, times, errors = Pose(), [], []
        for number in range(1, round(seconds * RATE) + 1):
            pose = step(pose, linear / RATE, angular / RATE)
            time = number / RATE
            x, y = math.sin(angular * time), 1.0 - math.cos(angular * time)
            times.append(time)
            # What is exactly right has no place on this axis.
            error = math.hypot(pose.x - x * linear / angular, pose.y - y * linear / angular)
            errors.append(max(error, 1e-16))
        label = f"{name}: at most {max(errors):.2g} m"
        axes.semilogy(times, errors, color=colour, linewidth=0.8, label=label)
    axes.set_xlabel("time, s")
    axes.set_ylabel("distance from the true place, m")
    axes.set_xlim(0.0, seconds)
    axes.set_ylim(1e-20, 1.0)
    axes.legend(loc="lower right", frameon=False, ncol=2)
    return "error of four ways to integrate the robot's motion"


def odometry(figure: Any) -> str:
    """Draw where 200 robots that drive the same way believe to be."""
    noise = 0.004
    axes = figure.add_subplot()
    commands = ((0.2, 0.0, 10.0), (0.2, 0.314, 5.0), (0.2, 0.0, 10.0))
    true: List[Pose] = []
    for seed in range(200):
        robot = Robot(BURGER._replace(odometry_noise=noise), seed=seed)
        for linear, angular, seconds in commands:
            robot.command(linear, angular)
            for _ in range(round(seconds * 10)):
                robot.step(0.1)
                if seed == 0:
                    true.append(robot.pose)
        believed = robot.odometry.pose
        axes.plot(believed.x, believed.y, ".", color=COLOURS[1], markersize=3)
        if seed == 0:
            covariance = robot.odometry.covariance
    axes.plot([p.x for p in true], [p.y for p in true], color=COLOURS[0], label="true path")
    axes.plot(*_ellipse(true[-1], covariance), color="#333333", label="covariance, 95 %")
    axes.plot([], [], ".", color=COLOURS[1], label="where 200 robots believe to be")
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    return "ends of 200 runs by odometry, and the ellipse of their covariance"


def _ellipse(centre: Pose, covariance: Any) -> Tuple[List[float], List[float]]:
    """Return the outline within which 95 % of all cases are, of two dimensions."""
    xx, xy, _, yy, _, _ = covariance
    root = numpy.linalg.cholesky([[xx, xy], [xy, yy]]) * math.sqrt(-2.0 * math.log(0.05))
    angles = numpy.linspace(0.0, 2.0 * math.pi, 200)
    x, y = root @ [numpy.cos(angles), numpy.sin(angles)]
    return (x + centre.x).tolist(), (y + centre.y).tolist()


PLOTS = {"paths": paths, "methods": methods, "odometry": odometry}


class DrivePlot(SphinxDirective):
    """A plot of some runs."""

    required_arguments = 1

    def run(self) -> List[nodes.Node]:
        name = self.arguments[0]
        if name not in PLOTS:
            raise self.error(f"no plot {name!r}; there are {', '.join(PLOTS)}")
        picture = f"{FOLDER}/drive_{name}.svg"
        plt.rcParams.update({"svg.hashsalt": "basic_comms", "font.size": 8})
        figure = plt.figure(figsize=(7.0, 3.6))
        alt = PLOTS[name](figure)
        for axes in figure.axes:
            axes.spines["top"].set_visible(False)
            axes.spines["right"].set_visible(False)
            axes.grid(color="#dddddd", linewidth=0.5)
        figure.tight_layout()
        path = Path(self.env.srcdir, picture)
        path.parent.mkdir(exist_ok=True)
        figure.savefig(path, metadata={"Date": None})
        plt.close(figure)
        return [nodes.image(uri="/" + picture, alt=alt)]


def setup(app: Any) -> Dict[str, bool]:
    """Register the directive with Sphinx."""
    app.add_directive("drive-plot", DrivePlot)
    return {"parallel_read_safe": True}
