"""Tests of ci/ros2-wheels: the oldest Python decides; no change without wheels."""

import pathlib
from typing import Tuple

import pytest

from .conftest import CI, Workspace

#: Fake uv: logs its arguments and constraints, and chooses a version.
UV = """#!/bin/sh -e
while [ $# -gt 1 ]; do
    case $1 in
        --python-version) python=$2 ;;
        --constraint) bound=$(cat "$2") ;;
    esac
    shift
done
echo "$python: $bound" >>"{log}"
[ "$python" != "{missing}" ] || exit 1
echo "${bound:-a==1.1}"
"""


@pytest.fixture
def wheels(workspace: Workspace) -> pathlib.Path:
    """Return a workspace with the list of wheels, and a package that names the Pythons."""
    workspace.pretend_packages("[run]\n[ros2]\n")
    workspace.program = "ros2-wheels"
    package = workspace.root / "modules" / "ros2_bridge" / "environment"
    package.mkdir(parents=True)
    (package / "python_environment.py").write_text("PYTHONS = ((3, 11), (3, 9))\n")
    chosen = workspace.root / "src" / "ros2_bridge" / "config" / "wheels.txt"
    chosen.parent.mkdir(parents=True)
    chosen.write_text("a==1.0\n")
    for other in ("build_tools.txt", "command_line.txt"):
        chosen.with_name(other).write_text("a==1.0\n")
    rosbags = workspace.root / "src" / "topic_scope" / "config" / "rosbags.txt"
    rosbags.parent.mkdir(parents=True)
    rosbags.write_text("a==1.0\n")
    return chosen


def run(workspace: Workspace, missing: str = "") -> Tuple[str, int]:
    """Run it, and return its output and status."""
    uv = workspace.root / "build" / "uv"
    (uv / "bin").mkdir(parents=True)
    wanted = (CI / "ros2-wheels").read_text().partition("fetch_tool uv ")[2].split()[0]
    (uv / "made").write_text(wanted)
    log = workspace.root / "log"
    (uv / "bin" / "uv").write_text(UV.replace("{log}", str(log)).replace("{missing}", missing))
    (uv / "bin" / "uv").chmod(0o755)
    done = workspace.run(PYTHONPATH=str(workspace.root / "modules"))
    assert missing in done.stderr
    return done.stdout, done.returncode


def test_oldest_python_chooses_for_all(workspace: Workspace, wheels: pathlib.Path) -> None:
    printed, status = run(workspace)
    assert (workspace.root / "log").read_text().splitlines() == [
        "3.9: ",
        "3.11: a==1.1",
        "3.11: ",  # the lists for recordings, for build tools and for the command ros2
        "3.11: ",
        "3.11: ",
    ]
    assert status == 0 and "< a==1.0\n" in printed and "> a==1.1\n" in printed
    assert wheels.read_text() == "a==1.1\n"
    rosbags = workspace.root / "src" / "topic_scope" / "config" / "rosbags.txt"
    assert rosbags.read_text() == "a==1.1\n"
    assert wheels.with_name("build_tools.txt").read_text() == "a==1.1\n"


def test_list_is_kept_without_wheels(workspace: Workspace, wheels: pathlib.Path) -> None:
    printed, status = run(workspace, missing="3.11")
    assert (printed, status) == ("", 125)
    assert wheels.read_text() == "a==1.0\n"


def test_chosen_are_those_that_are_wanted() -> None:
    wanted, chosen = (
        {
            line.split("==")[0].strip().lower().replace("_", "-")
            for line in (CI.parent / name).read_text("utf-8").splitlines()
            if line and line[0] not in "# "
        }
        for name in ("packaging/ros2_wheels.txt", "src/ros2_bridge/config/wheels.txt")
    )
    assert "ros-rclpy" in wanted and chosen == wanted
