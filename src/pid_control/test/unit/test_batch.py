"""Tests of batch runs: finding, building and judging the packages of a class."""

import os
import pathlib
import sys
import time
from typing import List

import pytest

from pid_control.runner import batch
from pid_control.runner.batch import packages_in, run_bounded

#: Stands for a build: makes a workspace, and says something in the user's language.
CATKIN_MAKE = """#!/bin/sh
mkdir -p "$2/devel/lib/x" && touch "$2/devel/env.sh" "$2/devel/lib/x/program"
echo "{says} ($LC_ALL)"
exit {status}
"""


def put_catkin_make(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", says: str, status: int
) -> None:
    """Have a catkin_make that does nothing but this found first."""
    (tmp_path / "catkin_make").write_text(CATKIN_MAKE.format(says=says, status=status))
    (tmp_path / "catkin_make").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")


def build_with(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", says: str, status: int
) -> str:
    """Build a package by a catkin_make that does nothing but this; return the workspace."""
    put_catkin_make(tmp_path, monkeypatch, says, status)
    (tmp_path / "x").mkdir()
    return batch.build(str(tmp_path / "x"), str(tmp_path / "scratch"))


def found(folder: pathlib.Path) -> List[str]:
    return [os.path.relpath(package, str(folder)) for package in packages_in(str(folder))]


def test_packages_are_found_in_folders_and_not_in_each_other(tmp_path: pathlib.Path) -> None:
    for name in ("b", "a/src/deep", "b/inner", "a/src/x/too_deep", "ignored/c"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "package.xml").write_text("")
    (tmp_path / "ignored" / "CATKIN_IGNORE").write_text("")
    assert found(tmp_path) == ["a/src/deep", "b"]


def test_a_folder_that_is_a_package_is_its_only_one(tmp_path: pathlib.Path) -> None:
    (tmp_path / "package.xml").write_text("")
    assert found(tmp_path) == ["."]


@pytest.mark.parametrize(
    "text, needs",
    [
        ("add_executable(x x.cpp)", True),
        ("  catkin_python_setup()", True),
        ("generate_messages()", True),
        ("# add_executable(x)", False),
        ("catkin_package()", False),
    ],
)
def test_needs_build_depends_on_cmake_commands(
    tmp_path: pathlib.Path, text: str, needs: bool
) -> None:
    assert not batch._needs_build(str(tmp_path))
    (tmp_path / "CMakeLists.txt").write_text("project(x)\n" + text + "\n")
    assert batch._needs_build(str(tmp_path)) is needs


def test_first_error_returns_line_and_next_line() -> None:
    text = "ok\nx.cpp:1: error: expected ')'\n  int main( {\nmake: Error 2\n"
    assert batch._first_error(text) == "x.cpp:1: error: expected ')' int main( {"
    assert batch._first_error("just this\n") == "just this"
    assert batch._first_error("") == ""


def test_build_nonzero_status_is_a_failure(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    with pytest.raises(batch._Broken, match=r"it does not build: Fehler 2 \(C\)"):
        build_with(tmp_path, monkeypatch, "Fehler 2", 1)


def test_build_warning_with_the_word_error_is_not_a_failure(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    workspace = build_with(tmp_path, monkeypatch, "warning: x = 1; // Error of the integral", 0)
    assert os.path.isdir(workspace)


def test_batch_judges_a_program_that_the_build_creates(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    put_catkin_make(tmp_path, monkeypatch, "built", 0)
    package, judge = tmp_path / "class" / "x", tmp_path / "judge"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("")
    (package / "CMakeLists.txt").write_text("add_executable(program program.cpp)\n")
    judge.write_text("import sys; print('judged:', sys.argv[-1])")
    monkeypatch.setattr(sys, "argv", [str(judge)])
    output = tmp_path / "out"
    batch.Batch(str(tmp_path / "class"), ["program"], [], str(output), 10.0).run()
    said = (output / "x.txt").read_text()
    assert said.startswith("judged: ") and said.endswith("/workspace/devel/lib/x/program\n")


def test_run_bounded_ends_a_hanging_command(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(batch, "_BEYOND_S", 0.2)
    began = time.monotonic()
    command = ["sh", "-c", "trap '' INT; echo begun; sleep 60 & wait; sleep 60"]
    assert run_bounded(command, 0.5, dict(os.environ))[0] == "begun\n"
    assert time.monotonic() - began < 20.0
