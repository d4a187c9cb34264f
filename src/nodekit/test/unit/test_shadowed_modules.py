"""Tests of the check for files that hide a module of Python or ROS."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = "import rospy\nfrom nodekit import Node, run\nprint(Node, run)\n"
PORTED = "from nodekit import Node, run\nprint(Node, run)\n"


def run_script(path: Path, **environment: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, str(path)],
        cwd="/",
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )


@pytest.mark.parametrize("text", [SCRIPT, PORTED], ids=["with rospy", "without"])
@pytest.mark.parametrize("name", ["signal", "queue", "rospy", "random"])
def test_script_with_the_name_of_a_module_is_named_in_one_line(
    tmp_path: Path, name: str, text: str
) -> None:
    path = tmp_path / f"{name}.py"
    path.write_text(text)
    done = run_script(path)
    sentence = f"{path}: the file hides the module {name}, which every node needs, from {name}.py"
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"{sentence}; rename the file\n"


def test_file_beside_the_script_is_named(tmp_path: Path) -> None:
    (tmp_path / "queue.py").write_text("")
    (tmp_path / "talker.py").write_text(PORTED)
    done = run_script(tmp_path / "talker.py")
    assert done.returncode == 1 and done.stderr.startswith(f"{tmp_path}/queue.py: the file hides")


def test_other_files_beside_the_script_are_its_own(tmp_path: Path) -> None:
    for name in ("talker.py", "process.py", "this.py", "signals.py"):
        (tmp_path / name).write_text(PORTED)
    assert run_script(tmp_path / "talker.py").returncode == 0


def test_file_without_a_name_clash_is_accepted(tmp_path: Path) -> None:
    for name in ("time.py", "os.py", "talker.py"):  # built in, and loaded before the script
        (tmp_path / name).write_text(PORTED)
    assert run_script(tmp_path / "talker.py").returncode == 0


def test_program_of_python_itself_may_import_nodekit() -> None:
    done = subprocess.run([sys.executable, "-m", "pydoc", "nodekit"], stdout=subprocess.PIPE)
    assert b"nodekit" in done.stdout and done.returncode == 0


def test_file_on_the_import_path_is_named_before_it_does_harm(tmp_path: Path) -> None:
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts" / "talker.py").write_text(PORTED)
    (tmp_path / "queue.py").write_text("")
    (tmp_path / "mine.py").write_text("")
    python = os.path.dirname(os.__file__)
    folders = ["/no/such/folder", str(tmp_path), os.environ["PYTHONPATH"], python]
    path = os.pathsep.join(folders)
    done = run_script(tmp_path / "scripts" / "talker.py", PYTHONPATH=path)
    assert done.stderr.splitlines()[0] == (
        f"{tmp_path}/queue.py: the file is on PYTHONPATH and hides the module queue from every "
        "program; rename the file"
    )
    assert done.stderr.count("is on PYTHONPATH") == 1
