"""Judge controllers whose flaws are known, and a class with packages that are broken."""

import contextlib
import csv
import os
import pathlib
import shutil
import subprocess
import time
from typing import Dict, List, Tuple

from ..benchmark.peer_programs import WORKSPACE
from .checks import Check, at_least, at_most, none_of, reported
from .surroundings import Soak

PACKAGE = WORKSPACE / "src" / "pid_control"
JUDGE = PACKAGE / "scripts" / "judge"
CONTROLLERS = PACKAGE / "test" / "controllers"
#: What the judge has to say first of each controller with a flaw.
FLAWS = {
    "crash": "crash",
    "crash_at_start": "crash",
    "deaf": "deaf",
    "derivative_kick": "derivative kick",
    "endless_output": "endless output",
    "flood": "flood",
    "mute": "silent",
    "nan": "nan",
    "no_clamp": "no clamp",
    "no_integral": "no integral",
    "sign": "sign",
    "silent": "silent",
    "stale": "stale",
    "time_sleep": "machine clock",
    "time_time": "machine clock",
    "too_seldom": "too seldom",
    "too_slow": "too slow",
    "windup": "windup",
    "wrong_dt": "interval",
}
#: Fewest controllers with a flaw, and without one.
FEWEST_FLAWED, FEWEST_GOOD = 12, 5
#: How long a judgement may take, s; and one of a class, of which two packages are built.
LONGEST_S, CLASS_S = 60.0, 400.0
#: A package.xml that builds.
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
SETUP = """from catkin_pkg.python_setup import generate_distutils_setup
from distutils.core import setup
setup(**generate_distutils_setup(packages=["{name}"], package_dir={{"": "src"}}))
"""
#: A controller that is started, and never comes to its topics.
HANGS = """#!/usr/bin/env python3
import rospy
from std_msgs.msg import Empty
rospy.init_node("controller")
rospy.wait_for_message("/nobody", Empty)
"""


def run(soak: Soak) -> List[Check]:
    """Judge all of them, one after the other."""
    return alone(soak.session.directory) + together(soak.session.directory)


def alone(directory: pathlib.Path) -> List[Check]:
    """Judge each controller by itself."""
    files = sorted(CONTROLLERS.glob("flaw_*.py"))
    missed, longest = [], 0.0
    for file in files:
        row, seconds = judged(directory, file)
        longest = max(longest, seconds)
        expected = FLAWS[file.stem[len("flaw_") :]]
        if row["flaws"].split(", ")[0] != expected:
            missed.append(f"{file.stem}: {row['flaws'] or row['verdict']}, not {expected}")
    good = [*sorted(CONTROLLERS.glob("good_*.py")), PACKAGE / "scripts" / "controller.py"]
    blamed = []
    for file in good:
        row, seconds = judged(directory, file)
        longest = max(longest, seconds)
        if row["verdict"] != "passed":
            blamed.append(f"{file.stem}: {row['verdict']}: {row['why']}")
    return [
        at_least("controllers with a flaw", len(files), FEWEST_FLAWED),
        at_least("controllers without one", len(good), FEWEST_GOOD),
        none_of("flaws that are not named", missed),
        none_of("good controllers that do not pass", blamed),
        at_most("longest judgement", longest, LONGEST_S, "s"),
        none_of("processes left behind", left_behind(directory)),
    ]


def together(directory: pathlib.Path) -> List[Check]:
    """Judge a class, of which some packages are broken."""
    folder = directory / "class"
    make_package(folder, "good", CONTROLLERS / "good_numpy.py")
    make_package(folder, "built", CONTROLLERS / "good_loop.py", "catkin_python_setup()")
    move_into_module(folder / "built")
    broken = make_package(folder, "unbuilt", CONTROLLERS / "good_numpy.py", "add_executable(x x.c)")
    (broken / "x.c").write_text("int main( {\n")
    hangs = make_package(folder, "hangs", CONTROLLERS / "good_numpy.py")
    (hangs / "scripts" / "controller.py").write_text(HANGS)
    began = time.monotonic()
    output = directory / "judged"
    status = judge(directory, "--output", output, "--class", folder)
    seconds = time.monotonic() - began
    with (output / "class.csv").open() as file:
        rows = {row["controller"]: row for row in csv.DictReader(file)}
    expected = {
        "good": ("passed", ""),
        "built": ("passed", ""),
        "unbuilt": ("not judged", "it does not build"),
        "hangs": ("failed", "does not publish motor_input"),
    }
    wrong = [
        f"{name}: {rows[name]['verdict']}: {rows[name]['why']}"
        for name, (verdict, why) in expected.items()
        if rows[name]["verdict"] != verdict or why not in rows[name]["why"]
    ]
    return [
        none_of("class: packages that are judged wrongly", wrong),
        at_most("class: exit status", status, 1),
        at_most("class: time", seconds, CLASS_S, "s"),
        reported("class: of the broken one", rows["unbuilt"]["why"]),
        none_of("class: processes left behind", left_behind(directory)),
    ]


def judged(directory: pathlib.Path, controller: pathlib.Path) -> Tuple[Dict[str, str], float]:
    """Judge a controller.

    :returns: its line of the CSV file, and how long it took, s
    """
    began = time.monotonic()
    table = directory / "judged.csv"
    judge(directory, "--csv", table, controller)
    with table.open() as file:
        [row] = csv.DictReader(file)
    table.unlink()
    return row, time.monotonic() - began


def judge(directory: pathlib.Path, *words: object) -> int:
    """Run the judge, its output in a log, and return its exit status."""
    with (directory / "judge.log").open("ab") as log:
        done = subprocess.run(
            [str(JUDGE), *map(str, words)],
            env={**os.environ, "TMPDIR": str(directory)},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            timeout=2.0 * CLASS_S,
        )
    return done.returncode


def left_behind(directory: pathlib.Path) -> List[str]:
    """Return the processes that the judge has started and that still run."""
    mark = f"TMPDIR={directory}".encode()
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if mark in (process / "environ").read_bytes().split(b"\0"):
                found.append((process / "cmdline").read_bytes().decode())
    return found


def make_package(
    folder: pathlib.Path, name: str, controller: pathlib.Path, line: str = ""
) -> pathlib.Path:
    """Make a submission.

    :param line: of its CMakeLists.txt
    """
    package = folder / name
    (package / "scripts").mkdir(parents=True)
    (package / "package.xml").write_text(MANIFEST.format(name=name))
    (package / "CMakeLists.txt").write_text(CMAKE.format(name=name, line=line))
    shutil.copy(str(controller), str(package / "scripts" / "controller.py"))
    return package


def move_into_module(package: pathlib.Path) -> None:
    """Have the controller's skeleton in a Python module of the package, which has to be built."""
    name = package.name
    (package / "setup.py").write_text(SETUP.format(name=name))
    module = package / "src" / name
    module.mkdir(parents=True)
    (module / "__init__.py").write_text("")
    shutil.copy(str(CONTROLLERS / "student.py"), str(module))
    script = package / "scripts" / "controller.py"
    script.write_text(script.read_text().replace("from student", f"from {name}.student"))
