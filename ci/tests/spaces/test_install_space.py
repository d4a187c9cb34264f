"""Tests of an install space, as ``catkin_make install`` makes it from the workspace's build."""

import os
import pathlib
import signal
import subprocess
from typing import Callable, Dict, List

import pytest

from .conftest import PACKAGES, SOURCES, WORKSPACE, wait_for_master

CHECK = SOURCES.parent / "ci" / "lint" / "launch_files.py"
CONTROLLER = ("pid_control", "motor_control.launch")
# Only a hang takes as long: a check of eleven launch files has taken more than a minute on a
# machine with a tenfold load.
LIMIT_S = 300.0

# A command in the install space, its streams and its process.
Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture(scope="session")
def install_space(
    tmp_path_factory: "pytest.TempPathFactory", underlay: Dict[str, str]
) -> pathlib.Path:
    """Install all packages below another root, as a Debian package does."""
    place = tmp_path_factory.mktemp("spaces")
    # Without bytecode of modules that the tests do not import.
    environment = {**underlay, "DESTDIR": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    subprocess.check_call(["cmake", "--install", str(WORKSPACE / "build")], env=environment)
    (found,) = place.rglob(".catkin")
    return found.parent


@pytest.fixture
def start(install_space: pathlib.Path, underlay: Dict[str, str]) -> Start:
    """Start a command in the install space."""

    def start_command(*command: str) -> "subprocess.Popen[str]":
        return subprocess.Popen(
            ["bash", "-c", 'source "$0/setup.bash" && exec "$@"', str(install_space), *command],
            env=underlay,
            stdout=subprocess.PIPE,
            universal_newlines=True,
        )

    return start_command


def output(process: "subprocess.Popen[str]") -> str:
    out, _ = process.communicate(timeout=LIMIT_S)
    assert process.returncode == 0, out
    return out.strip()


def names_below(directory: pathlib.Path) -> List[str]:
    return sorted(str(path.relative_to(directory)) for path in directory.rglob("*.*"))


def test_each_package_is_found(install_space: pathlib.Path, start: Start) -> None:
    names = [package.name for package in PACKAGES]
    found = output(start("sh", "-c", 'for name; do rospack find "$name"; done', "sh", *names))
    assert found.splitlines() == [str(install_space / "share" / name) for name in names]


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_package_has_its_files(package: pathlib.Path, install_space: pathlib.Path) -> None:
    share = install_space / "share" / package.name
    for kind in ("launch", "config"):
        assert names_below(share / kind) == names_below(package / kind)
    programs = install_space / "lib" / package.name
    for script in (package / "scripts").glob("*"):
        assert os.access(str(programs / script.name), os.X_OK), script.name


def test_launch_files_find_their_nodes_and_includes(
    install_space: pathlib.Path, start: Start
) -> None:
    folders = [install_space / "share" / package.name / "launch" for package in PACKAGES]
    output(start("python3", str(CHECK), *map(str, filter(pathlib.Path.is_dir, folders))))


def test_the_course_runs(install_space: pathlib.Path, start: Start) -> None:
    launch = start("roslaunch", "basic_comms", "cw1.launch")
    try:
        wait_for_master(launch)
        assert output(start("rostopic", "echo", "-n", "1", "/proc_signal")).startswith("data: ")
        code = "import basic_comms; print(basic_comms.__file__)"
        assert output(start("python3", "-c", code)).startswith(str(install_space))
    finally:
        launch.send_signal(signal.SIGINT)
        launch.communicate(timeout=60)


def test_a_controller_is_judged(start: Start) -> None:
    """In an install space, program and limits are in other folders."""
    said = output(start("rosrun", "pid_control", "judge", "--only", "ramp", *CONTROLLER))
    assert said.endswith("passed: all 2 figures of 1 scenario")


def test_new_package_can_be_created(start: Start, tmp_path: pathlib.Path) -> None:
    made = output(start("rosrun", "nodekit", "new", "first_robot", str(tmp_path)))
    assert made.startswith(f"made {tmp_path}/first_robot\n")
    assert os.access(str(tmp_path / "first_robot" / "scripts" / "my_node"), os.X_OK)
