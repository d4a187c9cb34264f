"""Tests of the installation of packages by ci/exec, and of its errors."""

import contextlib
import os
import pathlib
import pty
import subprocess
import time
from typing import List

import pytest

from .conftest import Workspace

LISTED = """# a comment
[run ros]
catkin
[run]
one
two  # another
[test]
three
"""
SUDO_REFUSES = """
    echo "sudo: a password is required" >&2; echo sudo >> '%s'; false"""


def test_installs_only_what_is_missing(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, installed="catkin\none\n", known="two\n")
    workspace.fakes["apt-get"] += "; cat"  # may not take the command's input
    result = workspace.run("cat", stdin="input\n")
    assert (result.stdout, result.returncode) == ("input\n", 0)
    commands = log.read_text().splitlines()
    assert len(commands) == 1, commands
    assert commands[0].startswith("apt-get install --yes --no-install-recommends ")
    assert commands[0].endswith(" two")
    assert "apt-get install --no-install-recommends two" in result.stderr
    assert workspace.run("true").stderr == ""


def test_no_service_that_is_installed_keeps_the_lock(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["apt-get"] += f"; [ ! -e /proc/$BASHPID/fd/9 ] || echo open >> '{log}'"
    assert workspace.run("true").returncode == 0
    assert "open" not in log.read_text()


def test_updates_the_lists_if_a_package_is_not_in_them(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, installed="catkin\n", known="one\n")
    (log.parent / "mirror").write_text("one\ntwo\n")
    assert workspace.run("true").returncode == 0
    commands = log.read_text().splitlines()
    assert commands[0].startswith("apt-get update ")
    assert commands[1].endswith(" one two")


def test_reports_packages_missing_in_the_system(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, installed="catkin\n", known="one\n")
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "a Debian has no package two. ROS 1 is installed by apt on" in result.stderr
    assert [line.split()[1] for line in log.read_text().splitlines()] == ["update"]


def test_may_be_forbidden_to_install(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    result = workspace.run("echo", "not reached", CI_EXEC_NO_INSTALL="1")
    assert (result.stdout, result.returncode) == ("", 125)
    line = result.stderr.splitlines()[-1]
    assert line.replace("sudo ", "") == ("apt-get install --no-install-recommends catkin one two")
    assert log.read_text() == ""


def test_failed_installation_is_shown(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["apt-get"] = 'echo "E: as the test wants it"; [ "$1" = update ]'
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "E: as the test wants it" in result.stderr


def test_printed_commands_install_even_with_missing_lists(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    (log.parent / "mirror").write_text("catkin\none\ntwo\n")
    result = workspace.run("echo", "not reached", CI_EXEC_NO_INSTALL="1")
    assert (result.stdout, result.returncode) == ("", 125)
    said, *lines = result.stderr.splitlines()
    assert said.startswith("ci/exec: packages are missing")
    assert [line.replace("sudo ", "").split()[:2] for line in lines] == [
        ["apt-get", "update"],
        ["apt-get", "install"],
    ]
    script = "\n".join(["set -e"] + lines)
    subprocess.check_call(["bash", "-c", script], env=workspace.environment())
    assert [path.name for path in (workspace.root / "build" / "ci-exec").iterdir()] == ["lock"]
    assert workspace.run("true", CI_EXEC_NO_INSTALL="1").returncode == 0


def test_without_sudo_prints_the_commands_for_root(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    workspace.be_somebody()
    workspace.fakes["command"] = '[ "$2" != sudo ] && builtin command "$@"'
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    said, *lines = result.stderr.splitlines()
    assert "without sudo only root" in said
    assert [line.split()[:2] for line in lines] == [["apt-get", "update"], ["apt-get", "install"]]
    assert log.read_text() == ""


def test_sudo_is_asked_once_and_its_refusal_is_reported(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    workspace.be_somebody("alice")
    workspace.fakes["command"] = '[ "$2" = sudo ] || builtin command "$@"'
    workspace.fakes["sudo"] = SUDO_REFUSES % log
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert log.read_text() == "sudo\n"
    *_, refused, said, update, install = result.stderr.splitlines()
    assert refused == "sudo: a password is required"
    assert "sudo did not let alice install packages" in said and "administrator" in said
    assert update == "apt-get update"
    assert install == "apt-get install --no-install-recommends catkin one two"


def test_proxies_reach_apt_through_sudo(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["env"] = f'echo "$*" >> "{log}"; {workspace.fakes["env"]}'
    assert workspace.run("true", http_proxy="http://proxy:1", https_proxy=None).returncode == 0
    calls = [line for line in log.read_text().splitlines() if "=" in line.split()[0]]
    assert calls and all("http_proxy=http://proxy:1 " in line for line in calls)


def test_unreachable_archive_is_reported(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    fault = "E: Failed to fetch http://mirror/x  Could not connect to proxy:1 (refused)"
    workspace.fakes["apt-helper"] = f"echo '{fault}'; false"
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert log.read_text() == ""
    said = result.stderr.splitlines()[-1]
    assert "no package can be downloaded" in said and "the proxy" in said
    assert "Could not connect to proxy:1 (refused)" in said


def test_an_archive_that_never_answers_is_given_up(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED)
    bin = workspace.root / "bin"
    bin.mkdir()
    (bin / "apt-helper").write_text("#!/bin/sh\nexec sleep 60\n")
    (bin / "apt-helper").chmod(0o755)
    del workspace.fakes["timeout"], workspace.fakes["apt-helper"]
    workspace.patch("packages.bash", "patience=40\n", "patience=1\n")
    began = time.monotonic()
    result = workspace.run("true", PATH=f"{bin}:{os.environ['PATH']}")
    assert result.returncode == 125
    assert "no answer within 1 s" in result.stderr
    assert time.monotonic() - began < 50.0


def test_last_archive_is_asked_with_a_time_limit(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    # For timeout, 0 is no limit. Each check takes a second.
    check = 'builtin [ "$@"; set -- $?; [[ ${FUNCNAME[1]} != refuse_* ]] || ((SECONDS += 1))'
    workspace.fakes["["] = f"{check}; return $1"
    workspace.fakes["timeout"] = f"echo $1 >> '{log}'; false"
    workspace.patch("packages.bash", "patience=40\n", "patience=3\n")
    assert workspace.run("true").returncode == 125
    limits = log.read_text().split()
    assert limits and "0" not in limits


def test_downloaded_packages_need_no_network(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["apt-helper"] = "false"
    apt_get = workspace.fakes["apt-get"]
    workspace.fakes["apt-get"] = '[[ $* != "install --print-uris"* ]] || return 0; ' + apt_get
    assert workspace.run("true").returncode == 0


def test_lists_that_could_not_be_had_are_not_a_lack_of_packages(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED)
    warning = "echo 'W: Failed to fetch http://mirror/debian'"
    workspace.fakes["apt-get"] += '; [ "$1" != update ] || ' + warning
    result = workspace.run("true")
    assert result.returncode == 125
    assert "W: Failed to fetch http://mirror/debian" in result.stderr
    assert "could not fetch all package lists" in result.stderr
    assert "has no package" not in result.stderr


def test_old_lists_are_renewed_and_the_installation_tried_again(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    old = "[ $1 = update ] || grep -qs 'apt-get update' '%s' || { echo >> '%s'; return 100; }; "
    apt_get = workspace.fakes["apt-get"].replace(
        '    echo "apt', old % (log, log) + '    echo "apt'
    )
    workspace.fakes["apt-get"] = apt_get
    assert workspace.run("true").returncode == 0
    assert [line.split()[1] for line in log.read_text().split("\n") if line] == [
        "update",
        "install",
    ]


def test_waits_for_the_lock_of_the_lists(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED)
    (log.parent / "mirror").write_text("catkin\none\ntwo\n")
    locked = """
        if [[ $1 == update && $* != *--print-uris* && ! -e '{0}/waited' ]]; then
            echo 'E: Could not get lock'; return 100
        fi;"""
    workspace.fakes["apt-get"] = locked.format(log.parent) + workspace.fakes["apt-get"]
    workspace.fakes["sleep"] = f": > '{log.parent}/waited'"
    assert workspace.run("true").returncode == 0
    assert (log.parent / "waited").exists()


def test_finishes_an_installation_that_was_cut_short(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["compgen"] = '[[ $2 == /var/lib/dpkg/* ]] || builtin compgen "$@"'
    workspace.fakes["dpkg"] = f"echo \"dpkg $*\" >> '{log}'"
    assert workspace.run("true").returncode == 0
    assert log.read_text().splitlines()[0] == "dpkg --configure -a"


def test_installation_without_effect_fails(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["apt-get"] = ":"
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert "has not installed catkin one two" in result.stderr


def test_long_installation_shows_progress_on_a_terminal(workspace: Workspace) -> None:
    log = workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    shown = log.parent / "shown"
    until = f"until [ -e '{shown}' ] || [ $SECONDS -gt 120 ]; do sleep 0.05; done"
    workspace.fakes["apt-get"] += f'; [[ $1 != install ]] || {{ echo "Unpacking two"; {until}; }}'
    workspace.patch("setup.bash", "every=5\n", "every=0.1\n")
    terminal, child_side = pty.openpty()
    process = subprocess.Popen(
        [str(workspace.root / "ci" / "exec"), "true"],
        env=workspace.environment(),
        stderr=child_side,
        start_new_session=True,
    )
    os.close(child_side)
    seen = b""
    with contextlib.suppress(OSError):  # the other side is closed
        while True:
            seen += os.read(terminal, 4096)
            if b" s: Unpacking two" in seen:
                shown.touch()
    os.close(terminal)
    assert process.wait(60) == 0
    assert shown.exists(), seen


def test_without_a_terminal_it_shows_no_progress(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    workspace.fakes["apt-get"] += '; [[ $1 != install ]] || { echo "Unpacking two"; sleep 0.5; }'
    workspace.patch("setup.bash", "every=5\n", "every=0.1\n")
    result = workspace.run("true")
    assert result.returncode == 0 and "Unpacking" not in result.stderr


@pytest.mark.parametrize("absent", ["apt-get", "dpkg-query"])
def test_refuses_a_system_without_apt_with_a_one_line_message(
    workspace: Workspace, absent: str
) -> None:
    log = workspace.pretend_packages(LISTED)
    workspace.fakes["command"] = f'[ "$2" != {absent} ] && builtin command "$@"'
    result = workspace.run("echo", "not reached")
    assert (result.stdout, result.returncode) == ("", 125)
    assert len(result.stderr.splitlines()) == 1
    assert "is not supported" in result.stderr
    assert log.read_text() == ""


def ros_in(prefix: pathlib.Path) -> pathlib.Path:
    """Create a fake installation of ROS 1."""
    (prefix / "share" / "rospy").mkdir(parents=True)
    (prefix / "share" / "rospy" / "package.xml").touch()
    (prefix / "setup.bash").write_text(f"export FAKE_ROS='{prefix}'\n")
    return prefix


@pytest.mark.parametrize(
    "there, sourced, taken",
    [
        (["opt/one", "opt/noetic"], "", "opt/noetic"),
        (["opt/one"], "", "opt/one"),
        (["opt/noetic", "mine"], "a_devel:mine", "mine"),
    ],
)
def test_uses_the_sourced_ros_or_the_ros_in_opt(
    workspace: Workspace, there: List[str], sourced: str, taken: str
) -> None:
    log = workspace.pretend_packages(LISTED, known="one\ntwo\n")
    for name in there:
        ros_in(workspace.root / name)
    (workspace.root / "a_devel").mkdir()
    (workspace.root / "a_devel" / "setup.bash").touch()
    workspace.patch("ros.bash", "=/opt/ros\n", f"='{workspace.root / 'opt'}'\n")
    workspace.fakes["catkin_make"] = 'mkdir -p devel; : > devel/setup.bash; echo "$FAKE_ROS"'
    path = ":".join(str(workspace.root / name) for name in sourced.split(":") if name)
    result = workspace.run("true", CMAKE_PREFIX_PATH=path)
    assert result.returncode == 0
    assert f"upon the ROS in {workspace.root / taken}, with" in result.stderr
    # ROS's own packages are part of that ROS, and the build extends it.
    assert log.read_text().splitlines()[0].endswith(" one two")
    built_on = (workspace.root / "build" / "ci-exec" / "log").read_text()
    assert f"{workspace.root / taken}\n" in built_on


def test_builds_with_the_python_that_a_ros_brings(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED, known="one\ntwo\n")
    prefix = ros_in(workspace.root / "env")
    (prefix / "bin").mkdir()
    (prefix / "bin" / "python3").symlink_to("/usr/bin/python3")
    workspace.fakes["catkin_make"] = 'mkdir -p devel; : > devel/setup.bash; echo "$@"'
    result = workspace.run("true", CMAKE_PREFIX_PATH=str(prefix))
    assert result.returncode == 0
    arguments = (workspace.root / "build" / "ci-exec" / "log").read_text()
    assert f"-DPYTHON_EXECUTABLE={prefix}/bin/python3" in arguments
    (prefix / "bin" / "python3").unlink()
    (prefix / "bin" / "python3").write_text("#!/bin/sh\nexit 1\n")
    (prefix / "bin" / "python3").chmod(0o755)
    result = workspace.run("true", CMAKE_PREFIX_PATH=str(prefix))
    assert result.returncode == 125 and "older than Python 3.8" in result.stderr


def test_without_apt_it_names_packages_missing_in_another_ros(workspace: Workspace) -> None:
    workspace.pretend_packages(LISTED)
    prefix = ros_in(workspace.root / "env")
    workspace.fakes["command"] = '[ "$2" != apt-get ] && builtin command "$@"'
    workspace.fakes["catkin_make"] = "mkdir -p devel; : > devel/setup.bash"
    result = workspace.run("true", CMAKE_PREFIX_PATH=str(prefix))
    assert result.returncode == 0
    assert "rosdep install" in result.stderr and " one two" in result.stderr
    assert "rosdep" not in workspace.run("true", CMAKE_PREFIX_PATH=str(prefix)).stderr


def test_hung_installation_is_reported_without_a_terminal(
    workspace: Workspace,
) -> None:
    log = workspace.pretend_packages(LISTED, known="catkin\none\ntwo\n")
    said = log.parent / "said"
    hangs = f"echo 'Connecting to mirror'; until grep -q 'Connecting' '{said}'; do sleep 0.1; done"
    workspace.fakes["apt-get"] += f"; [[ $1 != install ]] || {{ {hangs}; }}"
    workspace.patch("setup.bash", "stalled=30\n", "stalled=0.2\n")
    with said.open("w") as errors:
        subprocess.run(
            [str(workspace.root / "ci" / "exec"), "true"],
            env=workspace.environment(),
            stderr=errors,
            check=True,
            timeout=120,
        )
    assert "and nothing new for 0.2 s: Connecting to mirror" in said.read_text()
