"""Tests of the builds of ci/exec: only after changes, and restarted after a failure."""

import os
import pathlib
import pwd
import shutil
import signal
import subprocess
import time

import pytest

from .conftest import Workspace


def test_first_run_builds_and_keeps_the_streams_apart(workspace: Workspace) -> None:
    script = "cat; python3 -c 'import tiny.msg'; ls -l /proc/self/fd | grep -c lock; exit 7"
    result = workspace.run("sh", "-c", script, stdin="in\n")
    assert (result.stdout, result.returncode) == ("in\n0\n", 7)
    assert result.stderr == "ci/exec: building with catkin_make\n"


def test_rebuilds_what_changed_and_drops_what_is_gone(workspace: Workspace) -> None:
    workspace.add_package("spare")
    assert workspace.shows("tiny.Beat") and workspace.shows("spare.Beat")
    assert workspace.run("true").stderr == ""

    shutil.copy(
        str(workspace.root / "src/tiny/msg/Beat.msg"), str(workspace.root / "src/tiny/msg/Bar.msg")
    )
    # Messages are for Python only, unless C++ is requested; then for both from then on.
    headers = workspace.root / "devel" / "include" / "tiny"
    assert not headers.exists()
    assert "building" in workspace.run("true", ROS_LANG_DISABLE="genlisp").stderr
    assert workspace.run("true").stderr == ""
    assert workspace.shows("tiny.Bar")
    assert (headers / "Bar.h").exists()

    (workspace.root / "src/tiny/msg/Beat.msg").unlink()
    shutil.rmtree(str(workspace.root / "src/spare"))
    assert not workspace.shows("tiny.Beat")
    assert not workspace.shows("spare.Beat")
    assert workspace.shows("tiny.Bar")

    # The user's own "catkin_make clean" removes products behind the stamp's back.
    subprocess.check_call(
        ["make", "-C", str(workspace.root / "build"), "clean"], stdout=subprocess.DEVNULL
    )
    assert workspace.shows("tiny.Bar")


@pytest.mark.parametrize("built_by_hand", [False, True])
def test_moved_workspace_is_rebuilt(workspace: Workspace, built_by_hand: bool) -> None:
    assert workspace.shows("tiny.Beat")
    if built_by_hand:
        shutil.rmtree(str(workspace.root / "build" / "ci-exec"))
    moved = workspace.root.with_name("elsewhere")
    workspace.root.rename(moved)
    workspace.root = moved
    result = workspace.run("rospack", "find", "tiny")
    assert result.stdout.strip() == str(moved / "src" / "tiny")
    assert workspace.shows("tiny.Beat")


def test_two_simultaneous_runs_build_once(workspace: Workspace) -> None:
    both = [workspace.start("python3", "-c", "import tiny.msg") for _ in range(2)]
    ends = [(process.communicate(timeout=120)[1], process.returncode) for process in both]
    assert [status for _, status in ends] == [0, 0], ends
    assert "".join(err for err, _ in ends).count("building") == 1


def test_failed_build_is_shown_and_not_taken_for_finished(workspace: Workspace) -> None:
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
    workspace.fakes.clear()
    kept = ["mutants", "mutants.lock", "mypy", "ros2", "test-times.json"]
    for name in [*kept, "benchmark", "tiny"]:
        (workspace.root / "build" / name).mkdir()
        (workspace.root / "build" / name / "earlier").touch()
    result = workspace.run("python3", "-c", "import tiny.msg")
    assert result.returncode == 0
    assert "from scratch" in result.stderr
    earlier = (workspace.root / "build").glob("*/earlier")
    assert sorted(path.parent.name for path in earlier) == kept


def test_refuses_a_tree_of_catkin_build(workspace: Workspace) -> None:
    (workspace.root / "build").mkdir()
    (workspace.root / "build" / ".built_by").write_text("catkin build")
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "'catkin clean'" in result.stderr


def test_another_workspace_of_the_caller_stays_out(workspace: Workspace, built: Workspace) -> None:
    script = ". '%s/devel/setup.bash'; exec '%s/ci/exec' printenv CMAKE_PREFIX_PATH"
    shutil.rmtree(str(workspace.root / "src" / "tiny"))
    workspace.add_package("other")
    out = subprocess.check_output(
        ["bash", "-c", script % (built.root, workspace.root)], env=workspace.environment()
    )
    assert str(built.root) not in out.decode()
    assert workspace.shows("other.Beat") and not workspace.shows("tiny.Beat")


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
