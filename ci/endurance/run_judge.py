"""Judge controllers whose flaws are known, and a class with broken packages."""

import csv
import os
import pathlib
import shutil
import subprocess
import time
from typing import Dict, List

from ..benchmark.cost import with_variable
from ..benchmark.peer_programs import WORKSPACE
from .checks import Check, at_least, at_most, none_of, reported
from .context import Soak

PACKAGE = WORKSPACE / "src" / "pid_control"
CONTROLLERS = PACKAGE / "test" / "controllers"
#: The flaw that the judge has to name first, by controller, if it is not the controller's name.
FLAWS = {
    "crash_at_start": "crash",
    "mute": "silent",
    "time_sleep": "machine clock",
    "time_time": "machine clock",
    "wrong_dt": "interval",
}
#: Longest time of a judgement, and of one of the class, of which two packages are built [s].
LONGEST_S, CLASS_S = 60.0, 400.0
MANIFEST = """<package format="3"><name>{name}</name><version>0.0.0</version>
<description>A submission.</description><maintainer email="{name}@example.com">{name}</maintainer>
<license>BSD-3-Clause</license><buildtool_depend>catkin</buildtool_depend></package>
"""
CMAKE = """cmake_minimum_required(VERSION 3.5)
project({name})
find_package(catkin REQUIRED)
{line}
catkin_package()
"""
#: A controller that starts, and never creates its topics.
HANGS = """#!/usr/bin/env python3
import rospy
from std_msgs.msg import Empty
rospy.init_node("controller")
rospy.wait_for_message("/missing", Empty)
"""
#: Verdict and reason for each package of the class.
CLASS = {
    "good": ("passed", ""),
    "unbuilt": ("not judged", "it does not build"),
    "hangs": ("failed", "does not publish motor_input"),
}


def run(soak: Soak) -> List[Check]:
    """Judge all of them, one after the other."""
    return judge_alone(soak.session.directory) + judge_class(soak.session.directory)


def judge_alone(directory: pathlib.Path) -> List[Check]:
    """Judge each controller by itself."""
    flawed = sorted(CONTROLLERS.glob("flaw_*.py"))
    good = [*sorted(CONTROLLERS.glob("good_*.py")), PACKAGE / "scripts" / "controller.py"]
    missed, blamed, took = [], [], []
    for file in [*flawed, *good]:
        began = time.monotonic()
        judge(directory, "--csv", directory / "judged.csv", file)
        took.append(time.monotonic() - began)
        (row,) = read_rows(directory / "judged.csv")
        if file in good and row["verdict"] != "passed":
            blamed.append(f"{file.stem}: {row['verdict']}: {row['why']}")
        name = file.stem[len("flaw_") :]
        expected = FLAWS.get(name, name.replace("_", " "))
        if file in flawed and row["flaws"].split(", ")[0] != expected:
            missed.append(f"{file.stem}: {row['flaws'] or row['verdict']}, not {expected}")
    return [
        at_least("controllers judged", len(took), 24),
        none_of("flaws that are not named", missed),
        none_of("good controllers that do not pass", blamed),
        at_most("longest judgement", max(took), LONGEST_S, "s"),
        none_of("processes left behind", left_behind(directory)),
    ]


def judge_class(directory: pathlib.Path) -> List[Check]:
    """Judge a class, of which some packages are broken."""
    folder, output = directory / "class", directory / "judged"
    make_package(folder / "good")
    broken = make_package(folder / "unbuilt", "add_executable(x x.c)")
    (broken / "x.c").write_text("int main( {\n")
    hangs = make_package(folder / "hangs")
    (hangs / "scripts" / "controller.py").write_text(HANGS)
    began = time.monotonic()
    status = judge(directory, "--output", output, "--class", folder)
    took = time.monotonic() - began
    rows = {row["controller"]: row for row in read_rows(output / "class.csv")}
    wrong = [
        f"{name}: {rows[name]['verdict']}: {rows[name]['why']}"
        for name, (verdict, why) in CLASS.items()
        if rows[name]["verdict"] != verdict or why not in rows[name]["why"]
    ]
    return [
        none_of("class: packages that are judged wrongly", wrong),
        at_most("class: exit status", status, 1),
        at_most("class: time", took, CLASS_S, "s"),
        reported("class: of the broken one", rows["unbuilt"]["why"]),
        none_of("class: processes left behind", left_behind(directory)),
    ]


def judge(directory: pathlib.Path, *words: object) -> int:
    """Run the judge, with its output in a log, and return its exit status."""
    with (directory / "judge.log").open("ab") as log:
        done = subprocess.run(
            [str(PACKAGE / "scripts" / "judge"), *map(str, words)],
            env={**os.environ, "TMPDIR": str(directory)},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            timeout=2.0 * CLASS_S,
        )
    return done.returncode


def read_rows(file: pathlib.Path) -> List[Dict[str, str]]:
    """Return the rows of a CSV file, and remove it."""
    with file.open() as opened:
        rows = [dict(row) for row in csv.DictReader(opened)]
    file.unlink()
    return rows


def left_behind(directory: pathlib.Path) -> List[str]:
    """Return the processes that the judge has started and that still run."""
    return [str(pid) for pid in with_variable(f"TMPDIR={directory}")]


def make_package(package: pathlib.Path, line: str = "") -> pathlib.Path:
    """Make a submission with a good controller.

    :param line: of its CMakeLists.txt
    """
    (package / "scripts").mkdir(parents=True)
    (package / "package.xml").write_text(MANIFEST.format(name=package.name))
    (package / "CMakeLists.txt").write_text(CMAKE.format(name=package.name, line=line))
    script = package / "scripts" / "controller.py"
    shutil.copy(str(CONTROLLERS / "good_numpy.py"), str(script))
    return package
