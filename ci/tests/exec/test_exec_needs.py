"""Tests of the packages that ci/exec installs and builds for a command."""

import pathlib
import re
import shutil
import subprocess
from typing import Set

import pytest

from .conftest import CI, Workspace

SOURCES = CI.parent / "src"
#: References of launch files to packages.
STARTED = re.compile(r"""pkg="(\w+)"|\$\(find (\w+)\)|find\('(\w+)'\)""")
LISTED = "[run ros]\ncatkin\n[run]\nalways\nof_tiny\nof_key\nof_spare\nof_plot\n"
TABLE = """# key: run | build | of use
key: of_key | of_nothing
scripts/: | of_all
tiny: of_tiny
spare: of_spare | of_key  # another key may need it
plotter: of_plot
"""
LAUNCH = """<launch> <arg name="plot" default="false"
    doc="true plots; needs the package plotter"/> </launch>"""


def built_ones(workspace: Workspace) -> Set[str]:
    """Return the packages with generated messages."""
    place = workspace.root / "devel" / "lib" / "python3" / "dist-packages"
    return {path.parent.name for path in place.glob("*/msg")}


@pytest.fixture
def several(workspace: Workspace) -> Workspace:
    """Return a workspace in which user depends on tiny, and on spare in its tests only."""
    workspace.add_package("spare")
    workspace.add_package(
        "user", "<exec_depend\n>tiny</exec_depend><test_depend>spare</test_depend>"
    )
    return workspace


def test_builds_the_named_packages_and_adds_others_later(several: Workspace) -> None:
    said = several.run("rosrun", "user", "nothing").stderr
    assert "building with catkin_make: tiny user\n" in said
    assert built_ones(several) == {"tiny", "user"}
    # Tools use the existing build.
    assert several.run("rostopic", "--help").stderr == ""

    # Messages are for Python only, unless C++ is requested; then for both from then on. Nothing is
    # generated twice.
    source, devel = several.root / "src", several.root / "devel"
    shutil.copy(str(source / "tiny/msg/Beat.msg"), str(source / "tiny/msg/Bar.msg"))
    beat = devel / "lib/python3/dist-packages/tiny/msg/_Beat.py"
    assert not (devel / "include" / "tiny").exists()
    times = beat.stat().st_mtime_ns
    said = several.run("rosmsg", "show", "spare/Beat", ROS_LANG_DISABLE="genlisp").stderr
    assert said == "ci/exec: building with catkin_make: spare tiny user\n"
    assert built_ones(several) == {"spare", "tiny", "user"}
    assert (devel / "include" / "tiny" / "Bar.h").exists()
    assert beat.stat().st_mtime_ns == times
    assert several.run("rosrun", "tiny", "nothing").stderr.count("ci/exec") == 0

    # The products of removed packages and messages are removed, and later builds omit them.
    shutil.rmtree(str(source / "spare"))
    (source / "tiny/msg/Beat.msg").unlink()
    several.add_package("late")
    assert "from scratch with catkin_make: tiny user\n" in several.run("rostopic").stderr
    assert built_ones(several) == {"tiny", "user"}
    modules = devel / "lib/python3/dist-packages/tiny/msg"
    assert sorted(path.name for path in modules.glob("_*.py")) == ["_Bar.py", "__init__.py"]


def test_same_packages_are_built_elsewhere_and_the_others_at_need(several: Workspace) -> None:
    several.pretend_build()
    several.run("rosrun", "user", "nothing")
    moved = several.root.with_name("elsewhere")
    several.root.rename(moved)
    several.root = moved
    said = several.run("rostopic").stderr
    assert "ci/exec: building from scratch with catkin_make: tiny user\n" in said
    assert several.run("true").stderr == "ci/exec: building with catkin_make\n"
    assert several.run("rosrun", "tiny", "nothing").stderr.count("ci/exec") == 0


@pytest.mark.parametrize(
    "command, packages",
    [
        ("rosrun tiny node.py", "of_all of_key of_tiny"),
        ("roslaunch src/tiny/launch/a.launch", "of_all of_key of_tiny"),
        ("roslaunch tiny a.launch plot:=true", "of_all of_key of_plot of_tiny"),
        ("roslaunch tiny a.launch rate:=2.0", "of_all of_key of_tiny"),
        ("rostopic pub /beat tiny/Beat", "of_all of_key of_tiny"),
        ("rostopic list", "of_all of_key of_plot of_spare of_tiny"),
        ("rosrun rqt_graph rqt_graph", "of_all of_key of_plot of_spare of_tiny"),
        ("python3 -c 0 tiny", "of_all of_key of_plot of_spare of_tiny"),
        ("", "of_all of_key of_plot of_spare of_tiny"),
    ],
)
def test_installs_the_dependencies(workspace: Workspace, command: str, packages: str) -> None:
    shutil.rmtree(str(workspace.root / "src" / "tiny"))
    workspace.add_package("tiny", '<depend condition="1 == 1"> key </depend>')
    workspace.add_package("spare")
    workspace.add_package("plotter")
    (workspace.root / "src/tiny/launch").mkdir()
    (workspace.root / "src/tiny/launch/a.launch").write_text(LAUNCH)
    workspace.pretend_packages(LISTED + "of_all\n")
    (workspace.root / "packaging" / "dependencies.txt").write_text(TABLE)
    # Keys that the table lacks are for all packages.
    expected = ["catkin", "always", *packages.split()]
    result = workspace.run(*command.split(), CI_EXEC_NO_INSTALL="1")
    assert result.returncode == 125
    words = result.stderr.splitlines()[-1].split()
    assert sorted(words[words.index("--no-install-recommends") + 1 :]) == sorted(expected)


def test_package_built_once_is_kept_up_to_date(workspace: Workspace) -> None:
    workspace.add_package("spare")
    log = workspace.pretend_packages(
        LISTED, installed="catkin\nalways\nof_key\n", known="of_tiny\n"
    )
    (workspace.root / "packaging" / "dependencies.txt").write_text(TABLE)
    workspace.run("rosrun", "tiny", "nothing")
    assert log.read_text().splitlines()[0].endswith(" of_tiny")
    result = workspace.run("rosrun", "spare", "nothing", CI_EXEC_NO_INSTALL="1")
    assert result.stderr.splitlines()[-1].endswith(" of_spare")
    (log.parent / "installed").write_text("catkin\nalways\nof_key\n")
    result = workspace.run("rostopic", "list", CI_EXEC_NO_INSTALL="1")
    assert result.stderr.splitlines()[-1].endswith(" of_tiny")


def named_in_launch_files(package: pathlib.Path) -> Set[str]:
    """Return the packages of the workspace that a package's launch files use."""
    text = "".join(
        path.read_text("utf-8")
        for path in (package / "launch").rglob("*")
        if path.suffix in (".launch", ".xml")
    )
    names = {name for match in STARTED.findall(text) for name in match if name}
    asked = set(re.findall(r"needs the package (\w+)", text))
    return {name for name in names - asked if (SOURCES / name).is_dir()}


def test_packages_of_launch_files_are_dependencies() -> None:
    script = f"source '{CI}/setup/setup.bash'; dependencies | closure"
    seen: Set[str] = set()
    for package in sorted(path.parent for path in SOURCES.glob("*/launch")):
        out = subprocess.check_output(["bash", "-c", f"{script} {package.name}"]).decode()
        assert named_in_launch_files(package) <= set(out.split()), package.name
        seen |= set(out.split())
    assert {"basic_comms", "nodekit", "rospy"} <= seen
    plot = f"source '{CI}/setup/setup.bash'; packages_of_argument plot:=true"
    assert set(subprocess.check_output(["bash", "-c", plot]).decode().split()) == {"topic_scope"}
