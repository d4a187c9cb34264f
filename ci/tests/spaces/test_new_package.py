"""Test of a package created by ``rosrun nodekit new``: build, and its test."""

import os
import pathlib
import subprocess
from typing import Dict


def test_new_package_builds_and_passes_its_test(tmp_path: pathlib.Path) -> None:
    """Course 002-pkg-17."""
    (tmp_path / "src").mkdir()
    # Extends the workspace's devel space; without files for other languages, which take longest.
    environment = {**os.environ, "ROS_LANG_DISABLE": "gencpp:geneus:genlisp:gennodejs"}

    def run(*command: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            command,
            cwd=str(tmp_path),
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
        )

    made = run("rosrun", "nodekit", "new", "first_robot")
    assert made.stdout.startswith(f"made {tmp_path}/src/first_robot\n")
    # Otherwise catkin_make uses PWD, which is still the folder of this test's start.
    build = ("catkin_make", "--directory", str(tmp_path))
    built = run(*build, "-DPYTHON_EXECUTABLE=/usr/bin/python3", "run_tests")
    results = run("catkin_test_results", "--all", "build")
    assert results.returncode == 0, built.stdout + results.stdout
    counted: Dict[str, str] = dict(
        line.split(": ", 1) for line in results.stdout.splitlines() if ".xml: " in line
    )
    tested = {name: text for name, text in counted.items() if not text.startswith("0 tests")}
    for kind in ("rosunit-my_node", "roslaunch-check"):
        assert any(kind in name for name in tested), results.stdout
