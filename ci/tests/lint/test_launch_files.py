"""Tests of the check of launch files: faults, and an empty folder."""

import pathlib
import subprocess
import sys
from typing import Tuple

import pytest

CHECK = pathlib.Path(__file__).resolve().parents[2] / "lint" / "launch_files.py"

LAUNCH = "<launch><node pkg='%s' type='%s' name='a'/></launch>"


def check(folder: pathlib.Path) -> Tuple[str, int]:
    """Return the output and status of the check of a folder."""
    command = [sys.executable, str(CHECK), str(folder)]
    done = subprocess.run(command, stdout=subprocess.PIPE, encoding="utf-8", timeout=300)
    return done.stdout, done.returncode


def test_file_with_existing_nodes_is_good(tmp_path: pathlib.Path) -> None:
    (tmp_path / "good.launch").write_text(LAUNCH % ("basic_comms", "process.py"))
    assert check(tmp_path) == ("1 launch files, 0 of them with faults\n", 0)


@pytest.mark.parametrize(
    "text", [LAUNCH % ("basic_comms", "nowhere.py"), LAUNCH % ("no_such_package", "a"), "<launch>"]
)
def test_a_file_is_named_that_cannot_be_launched(tmp_path: pathlib.Path, text: str) -> None:
    (tmp_path / "good.launch").write_text(LAUNCH % ("basic_comms", "process.py"))
    (tmp_path / "bad.launch").write_text(text)
    said, status = check(tmp_path)
    assert status == 1 and "2 launch files, 1 of them with faults" in said
    assert f"{tmp_path}/bad.launch: " in said


def test_a_folder_without_launch_files_is_a_fault(tmp_path: pathlib.Path) -> None:
    assert check(tmp_path)[1] == 1
