"""Tests of the builds of ci/exec: only after changes, and restarted after a failure."""

import os
import pathlib
import pwd
import shutil
import signal
import time

import pytest

from .conftest import Workspace


FROM_SCRATCH = "ci/exec: building from scratch with catkin_make\n"


@pytest.fixture
def pretended(workspace: Workspace) -> Workspace:
    """Return a workspace that a fake catkin_make has built."""
    workspace.pretend_build()
    assert workspace.run("true").stderr == "ci/exec: building with catkin_make\n"
    assert workspace.run("true").stderr == ""
    return workspace


def test_first_run_builds_and_keeps_the_streams_apart(built: Workspace) -> None:
    assert (built.first.stdout, built.first.returncode) == ("in\n0\n", 7)
    assert built.first.stderr == "ci/exec: building with catkin_make\n"
    # By this line a build for another place is recognized.
    cache = (built.root / "build" / "CMakeCache.txt").read_text().splitlines()
    assert f"CMAKE_HOME_DIRECTORY:INTERNAL={built.root}/src" in cache


def test_product_that_is_gone_is_built_again(pretended: Workspace) -> None:
    """The user's own "catkin_make clean" removes products behind the stamp's back."""
    (pretended.root / "devel" / "product").unlink()
    assert pretended.run("true").stderr == "ci/exec: building with catkin_make\n"
    assert (pretended.root / "devel" / "product").exists()


@pytest.mark.parametrize("built_by_hand", [False, True])
def test_moved_workspace_is_built_from_scratch(pretended: Workspace, built_by_hand: bool) -> None:
    if built_by_hand:
        shutil.rmtree(str(pretended.root / "build" / "ci-exec"))
    (pretended.root / "devel" / "earlier").touch()
    moved = pretended.root.with_name("elsewhere")
    pretended.root.rename(moved)
    pretended.root = moved
    assert pretended.run("true").stderr == FROM_SCRATCH
    assert not (moved / "devel" / "earlier").exists()


def test_two_simultaneous_runs_build_once(workspace: Workspace) -> None:
    go_on = workspace.root / "go_on"
    workspace.pretend_build(f"until [ -e '{go_on}' ]; do sleep 0.05; done")
    first = workspace.start("true")
    assert first.stderr and "building" in first.stderr.readline()
    second = workspace.start("true")
    assert second.stderr and "waiting for it" in second.stderr.readline()
    go_on.touch()
    ends = [
        (process.communicate(timeout=120)[1], process.returncode) for process in (first, second)
    ]
    assert ends == [("", 0), ("", 0)]


def test_failed_build_is_shown_and_not_taken_for_finished(workspace: Workspace) -> None:
    workspace.pretend_build("! grep FATAL_ERROR src/tiny/CMakeLists.txt || return 1")
    assert workspace.run("true").returncode == 0
    lists = workspace.root / "src" / "tiny" / "CMakeLists.txt"
    good, times = lists.read_text(), os.stat(str(lists))
    lists.write_text(good + 'message(FATAL_ERROR "as the test wants it")\n')
    for _ in range(2):
        result = workspace.run("echo", "not reached")
        assert (result.stdout, result.returncode) == ("", 125)
        assert "as the test wants it" in result.stderr
    lists.write_text(good)
    os.utime(str(lists), ns=(times.st_atime_ns, times.st_mtime_ns))
    assert "building" in workspace.run("true").stderr


def test_interrupted_build_starts_over(workspace: Workspace) -> None:
    begun = workspace.root / "begun"
    # bash loses a SIGINT just before it executes another program; sh does not.
    workspace.fakes["catkin_make"] = f"""mkdir devel; : > devel/setup.bash
        sh -c ': > "$0"; exec sleep 60' '{begun}'"""
    process = workspace.start("echo", "not reached")
    deadline = time.monotonic() + 60.0
    while not begun.exists() and time.monotonic() < deadline:
        assert process.poll() is None
        time.sleep(0.01)  # poll
    os.killpg(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out == "" and process.returncode != 0
    workspace.pretend_build()
    kept = ["mutants", "mutants.lock", "mypy", "ros2", "test-times.json"]
    for name in [*kept, "benchmark", "tiny"]:
        (workspace.root / "build" / name).mkdir()
        (workspace.root / "build" / name / "earlier").touch()
    assert workspace.run("true").stderr == FROM_SCRATCH
    earlier = (workspace.root / "build").glob("*/earlier")
    assert sorted(path.parent.name for path in earlier) == kept


def test_refuses_a_tree_of_catkin_build(workspace: Workspace) -> None:
    (workspace.root / "build").mkdir()
    (workspace.root / "build" / ".built_by").write_text("catkin build")
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "'catkin clean'" in result.stderr


def test_another_workspace_of_the_caller_stays_out(workspace: Workspace) -> None:
    extend = "export CMAKE_PREFIX_PATH=$PWD/devel:${CMAKE_PREFIX_PATH-}"  # as catkin_make does
    workspace.pretend_build(f'mkdir -p devel; echo "{extend}" > devel/setup.bash')
    result = workspace.run("printenv", "CMAKE_PREFIX_PATH", CMAKE_PREFIX_PATH="/another/devel")
    assert result.stdout == f"{workspace.root}/devel:\n"


@pytest.mark.parametrize("sign", list("\"'$ \\#:\t"))
def test_refuses_a_path_that_ros_cannot_handle(tmp_path: pathlib.Path, sign: str) -> None:
    workspace = Workspace(tmp_path / f"one{sign}other")
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert len(result.stderr.splitlines()) == 1
    assert f"cannot handle the '{sign}' in" in result.stderr
    assert not (workspace.root / "build").exists()


@pytest.mark.parametrize("place", ["build", "build/ci-exec", "build/ci-exec/lock", "devel"])
def test_names_the_owner_of_the_build(workspace: Workspace, place: str) -> None:
    workspace.pretend_packages("[run]\none\n", installed="one\n")
    assert workspace.run("true").returncode == 0
    (workspace.root / "src" / "tiny" / "msg" / "Bar.msg").write_text("")
    workspace.give_away(place)
    workspace.be_somebody()
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    (line,) = result.stderr.splitlines()
    owner = pwd.getpwuid(os.getuid()).pw_name
    assert line.startswith(f"ci/exec: {workspace.root / place} belongs to {owner}, ")
    assert f"'chown -R daemon {workspace.root}/build {workspace.root}/devel'" in line


def test_reports_a_read_only_checkout(workspace: Workspace) -> None:
    workspace.pretend_packages("[run]\none\n")
    workspace.give_away(".")
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    (line,) = result.stderr.splitlines()
    assert f"cannot write to {workspace.root}/build/ci-exec" in line and "a clone" in line


def test_runs_a_build_of_any_owner(workspace: Workspace) -> None:
    workspace.pretend_packages("[run]\none\n", installed="one\n")
    assert workspace.run("true").returncode == 0
    workspace.give_away("build")
    workspace.be_somebody()
    assert workspace.run("true").returncode == 0
