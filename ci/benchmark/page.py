"""Table and picture of docs/benchmark.md, from the figures of benchmark.json in the same folder.

Usage: python3 ci benchmark.page FOLDER
"""

import json
import pathlib
import sys
from typing import Any, Dict, List, Tuple

from .analysis import Estimate
from .goals import number
from .report import interval, table
from .stacks import OURS, RCLPY, ROSCPP, ROSPY

STACKS = {OURS: "#2a7f62", ROSPY: "#9aa5b1", ROSCPP: "#567ebb", RCLPY: "#c8853d"}
FACTS = ("processor", "cores", "memory", "system", "python", "date")
#: Label, row of the benchmark, figure, and the subject of each column.
FIGURES = [
    ("latency at 1 kHz [µs]", "latency-1khz", "p50_us", list(STACKS)),
    ("processor time at 1 kHz [% of a core]", "latency-1khz", "cpu_percent", list(STACKS)),
    ("latency at 100 Hz [µs]", "latency-100hz", "p50_us", list(STACKS)),
    ("processor time at 100 Hz [% of a core]", "latency-100hz", "cpu_percent", list(STACKS)),
    ("`rosparam set` to its effect [ms]", "parameters", "median_ms", [OURS]),
    ("a robot and its controller [% of a core]", "robot", "cpu_percent", ["in two processes"]),
    ("the same in one process [% of a core]", "robot", "cpu_percent", ["in one process"]),
    ("bridge at 1 kHz, to ROS 2 [% of a core]", "bridge", "cpu_percent", ["to_ros2"]),
]
#: Label, row of the benchmark, and goal with the ratio for the first column.
RATIOS = [
    ("start, of the course's nodes'", "launch", "first answer, against the course's"),
    ("memory of a node, of a bare rospy node's", "memory", "a node, against a bare one"),
    ("control loop, of the latency at 1 kHz", "loop", "p50, against generator and process"),
    ("bridge to ROS 2, of a hop in each ROS", "bridge", "p50 to ROS 2, against a hop of each"),
    ("bridge to ROS 1, of a hop in each ROS", "bridge", "p50 to ROS 1, against a hop of each"),
]
#: Title and unit of each part of the picture, and its figure.
PANELS = [("latency [µs]", "p50_us"), ("processor time [% of a core]", "cpu_percent")]
RATES = [("1 kHz", "latency-1khz"), ("100 Hz", "latency-100hz")]

#: Values by row, figure or goal, and subject.
Reading = Dict[Tuple[str, str, str], Estimate]


def read(content: Dict[str, Any]) -> Reading:
    """Return the values of a file that ``ci/bench --json`` has written."""
    fields = Estimate._fields
    values = {
        (one["row"], one["figure"], one["of"]): Estimate(*(one[name] for name in fields))
        for one in content["figures"]
    }
    for one in content["goals"]:
        values[one["row"], one["what"], ""] = Estimate(*(one[name] for name in fields))
    return values


def make_table(values: Reading, machine: Dict[str, str]) -> str:
    """Return the table, without lines that lack values, and the machine."""
    rows: List[List[str]] = [["typical, and where it lies to 95 %", *STACKS]]
    for label, row, figure, subjects in FIGURES:
        rows.append([label, *(_cell(values, row, figure, subject) for subject in subjects)])
    for label, row, goal in RATIOS:
        ratio = _cell(values, row, goal, "")
        rows.append([label, ratio.replace(" ", " x ", 1) if " " in ratio else f"{ratio} x"])
    width = len(STACKS) + 1
    lines = [row + [""] * (width - len(row)) for row in rows if row[1].strip(" x")]
    facts = ", ".join(f"{name} {machine[name]}" for name in FACTS if name in machine)
    return f"{table(lines)}\n\nThe machine: {facts}.\n"


def _cell(values: Reading, row: str, key: str, subject: str) -> str:
    value = values.get((row, key, subject))
    if value is None:
        return ""
    where = interval(value)
    return number(value.median) + (f" ({where})" if where else "")


def draw(values: Reading, file: pathlib.Path) -> None:
    """Draw latency and processor time of each stack at each rate, with their intervals."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    matplotlib.rcParams.update({"font.size": 9, "svg.hashsalt": "bench", "svg.fonttype": "none"})
    picture, axes_of_all = pyplot.subplots(1, len(PANELS), figsize=(9.0, 2.6))
    for axes, (title, figure) in zip(axes_of_all, PANELS):
        for place, (stack, color) in enumerate(STACKS.items()):
            for number_of_rate, (_, row) in enumerate(RATES):
                value = values.get((row, figure, stack))
                if value is None:
                    continue
                errors = [[value.median - value.low], [value.high - value.median]]
                height = number_of_rate + 0.2 * (place - 1.5)
                label = stack if number_of_rate == 0 else None
                axes.barh(height, value.median, 0.18, xerr=errors, color=color, label=label)
                text = f"  {number(value.median)}"
                axes.text(value.high, height, text, va="center", fontsize=7)
        axes.margins(x=0.15)
        axes.set_yticks(range(len(RATES)))
        axes.set_yticklabels([rate for rate, _ in RATES])
        axes.invert_yaxis()
        axes.set_title(title, loc="left")
        axes.spines[["top", "right"]].set_visible(False)
    axes_of_all[-1].legend(frameon=False, loc="upper left", bbox_to_anchor=(1.02, 1.0))
    picture.tight_layout()
    picture.savefig(str(file), metadata={"Date": None})
    pyplot.close(picture)


def write(folder: pathlib.Path) -> None:
    """Write benchmark.inc and benchmark.svg."""
    content = json.loads((folder / "benchmark.json").read_text("utf-8"))
    values = read(content)
    (folder / "benchmark.inc").write_text(make_table(values, content["machine"]), "utf-8")
    draw(values, folder / "benchmark.svg")


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]))
