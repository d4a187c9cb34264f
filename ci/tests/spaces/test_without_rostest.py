"""Tests of a build without rostest or roslaunch, which skips the tests."""

import os
import pathlib
import subprocess

import pytest

from .conftest import SOURCES

LEFT_OUT = (
    "-- nodekit_tests: the tests are left out, as rostest and roslaunch are not both installed"
)


def build(package: pathlib.Path, folder: pathlib.Path, *options: str) -> str:
    """Configure a package and build it, without files for other languages.

    :param package: its folder
    :param folder: folder of the build
    :param options: options of cmake
    :returns: cmake's output
    """
    environment = {**os.environ, "ROS_LANG_DISABLE": "gencpp:geneus:genlisp:gennodejs"}
    configure = ["cmake", "-S", str(package), "-B", str(folder)]
    configure += ["-DPYTHON_EXECUTABLE=/usr/bin/python3", "-DCATKIN_ENABLE_TESTING=ON"]
    said = ""
    for command in ([*configure, *options], ["cmake", "--build", str(folder)]):
        done = subprocess.run(
            command,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
        )
        assert done.returncode == 0, done.stdout
        said += done.stdout
    return said


def targets_of_tests(folder: pathlib.Path) -> str:
    """Return the names of a build's test targets."""
    targets = subprocess.check_output(
        ["cmake", "--build", str(folder), "--target", "help"], universal_newlines=True
    )
    return "\n".join(line for line in targets.splitlines() if "_run_tests_" in line)


@pytest.fixture(scope="module")
def new_package(tmp_path_factory: "pytest.TempPathFactory") -> pathlib.Path:
    """Return a package created by ``rosrun nodekit new``."""
    folder = tmp_path_factory.mktemp("src")
    subprocess.check_call(["rosrun", "nodekit", "new", "first_robot", str(folder)])
    return folder / "first_robot"


@pytest.mark.parametrize("missing", ["rostest", "roslaunch"])
def test_new_package_builds_without(
    missing: str, new_package: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    said = build(new_package, tmp_path, f"-DCMAKE_DISABLE_FIND_PACKAGE_{missing}=ON")
    assert said.splitlines().count(LEFT_OUT) == 1
    assert targets_of_tests(tmp_path) == ""


def test_nodekit_itself_builds_without(tmp_path: pathlib.Path) -> None:
    said = build(SOURCES / "nodekit", tmp_path, "-DCMAKE_DISABLE_FIND_PACKAGE_rostest=ON")
    assert said.splitlines().count(LEFT_OUT) == 1
    assert targets_of_tests(tmp_path) == ""
