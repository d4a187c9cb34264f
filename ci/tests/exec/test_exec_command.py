"""Tests of the command that ci/exec runs: streams, status, process, and environment."""

import os
import pathlib
import pty
import pwd
import re
import signal
import socket
import subprocess
import time
from typing import Sequence

import pytest

from .conftest import Workspace

ROSBASH = (
    "/usr/share/bash-completion/completions/rosbash",
    f"{os.environ.get('ROS_ROOT')}/../rosbash/rosbash",
)
#: Python program that creates a file when it runs, and ends with 0 at Ctrl-C.
ENDS_BY_ITSELF = """
import signal, sys
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
open(sys.argv[1], "w").close()
signal.sigtimedwait([signal.SIGINT], 60.0)
"""
#: awk without buffered input, as gawk; and more listeners than fit into a pipe.
HASTY_AWK = {
    "awk": """case $(readlink -f "$(type -P awk)") in
        *mawk) command awk -W interactive "$@" ;;
        *) command awk "$@" ;;
    esac""",
    "tail": 'command tail "$@"; yes "0: 0:0000 0:0 0A 0 0 0 0" | head -n 20000',
}
PRINT_ENVIRONMENT = ("sh", "-c", 'echo "$ROS_HOSTNAME,${ROS_IP-none},$LANG"')


def test_streams_and_status_are_the_commands(built: Workspace) -> None:
    result = built.run("sh", "-c", "cat; echo err >&2; exit 7", stdin="in\n")
    assert (result.stdout, result.stderr, result.returncode) == ("in\n", "err\n", 7)


def test_command_takes_the_place_of_the_script(built: Workspace) -> None:
    process = built.start("sh", "-c", "echo $$")
    assert int(process.communicate(timeout=60)[0]) == process.pid


def test_arguments_arrive_unchanged(built: Workspace) -> None:
    arguments = ["--extend", "two words", "", "*"]
    result = built.run("printf", "<%s>", *arguments)
    assert result.stdout == "".join(f"<{argument}>" for argument in arguments)


def test_ctrl_c_ends_rosrun_while_it_searches(built: Workspace, tmp_path: pathlib.Path) -> None:
    begun, ran = tmp_path / "begun", tmp_path / "ran"
    node = built.root / "src" / "tiny" / "node"
    node.write_text(f"#!/bin/sh\necho \"$@\" > '{ran}'\n")
    node.chmod(0o755)
    try:
        assert built.run("rosrun", "tiny", "node", "two words").returncode == 0
        assert ran.read_text() == "two words\n"
        ran.unlink()
        # catkin_find is a Python program that may handle Ctrl-C. A trap of a shell would wait for
        # the end of a command that has just begun.
        built.fakes["catkin_find"] = f"exec /usr/bin/python3 -c '{ENDS_BY_ITSELF}' '{begun}'"
        process = built.start("rosrun", "tiny", "node")
        deadline = time.monotonic() + 60.0
        while not begun.exists() and time.monotonic() < deadline:
            assert process.poll() is None
            time.sleep(0.01)  # poll
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=60)
        assert (process.returncode, ran.exists()) == (-signal.SIGINT, False)
    finally:
        built.fakes.clear()
        node.unlink()


def test_unknown_command_is_127(built: Workspace) -> None:
    result = built.run("no-such-command")
    assert result.returncode == 127
    assert "no-such-command" in result.stderr


@pytest.mark.parametrize(
    "program, said",
    [
        ("exec", "CI_EXEC_NO_INSTALL=1  "),
        ("bench", "  latency-1khz "),
        ("soak", "  record "),
        ("two-hosts", "  closed "),
    ],
)
def test_help_is_the_header(workspace: Workspace, program: str, said: str) -> None:
    log = workspace.pretend_packages("[run]\none\n", known="one\n")
    workspace.program = program
    result = workspace.run("--help")
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout.startswith(f"Usage: ci/{program}")
    assert f"\n{said}" in result.stdout
    assert "set -e" not in result.stdout
    # The usage needs neither an installation nor a build.
    assert log.read_text() == "" and not (workspace.root / "build").exists()


def test_works_through_a_symbolic_link(built: Workspace, tmp_path: pathlib.Path) -> None:
    link = tmp_path / "ros"
    link.symlink_to(built.root / "ci" / "exec")
    result = subprocess.run([str(link), "rospack", "find", "tiny"], stdout=subprocess.PIPE)
    assert result.stdout.decode().strip() == str(built.root / "src" / "tiny")


@pytest.mark.parametrize(
    "changes, seen",
    [
        ({"LANG": "C"}, "localhost,none,C"),
        ({"ROS_HOSTNAME": "robot", "LANG": "C"}, "robot,none,C"),
        ({"ROS_IP": "192.0.2.1", "LANG": "C"}, ",192.0.2.1,C"),
        ({"ROS_HOSTNAME": "", "ROS_IP": "", "LANG": "C"}, "localhost,none,C"),
        ({"LANG": None, "LC_ALL": None, "LC_CTYPE": None}, "localhost,none,C.UTF-8"),
    ],
)
def test_defaults_of_the_environment(built: Workspace, changes: dict, seen: str) -> None:
    assert built.run(*PRINT_ENVIRONMENT, **changes).stdout.strip() == seen


def test_warns_of_a_remote_master_without_an_own_name(built: Workspace) -> None:
    remote = "http://robot:11311"
    assert remote in built.run("true", ROS_MASTER_URI=remote).stderr
    assert built.run("true", ROS_MASTER_URI=remote, ROS_IP="192.0.2.1").stderr == ""
    assert built.run("true", ROS_MASTER_URI="http://localhost:11312").stderr == ""


def test_master_without_scheme_gets_the_corrected_address(built: Workspace) -> None:
    for changes in ({}, {"ROS_IP": "192.0.2.1"}):
        told = built.run("true", ROS_MASTER_URI="robot:11311", **changes).stderr
        assert "'export ROS_MASTER_URI=http://robot:11311'" in told
        assert "ROS_IP" not in told


def test_another_python_is_kept_away(built: Workspace, tmp_path: pathlib.Path) -> None:
    shims = tmp_path / "venv" / "bin"
    shims.mkdir(parents=True)
    for name in ("python", "python3"):
        (shims / name).write_text("#!/bin/sh\nexit 66\n")
        (shims / name).chmod(0o755)
    modules = tmp_path / "lib" / "python3.7" / "site-packages"
    modules.mkdir(parents=True)
    (modules / "genpy.py").write_text("raise RuntimeError('of another python')\n")
    (tmp_path / "mine.py").write_text("")
    code = "import mine, genpy, os, tiny.msg; print(os.environ.get('VIRTUAL_ENV'))"
    result = built.run(
        "env",
        "python3",
        "-c",
        code,
        PATH=f"{shims}:{os.environ['PATH']}",
        VIRTUAL_ENV=str(tmp_path / "venv"),
        PYTHONHOME=str(tmp_path / "venv"),
        PYTHONPATH=f"{modules}:{tmp_path}",
    )
    assert (result.stdout, result.stderr) == ("None\n", "")
    assert built.run("sh", "-c", "command -v python", PATH=f"{shims}:/usr/bin").stdout != str(
        shims / "python"
    )


def test_shell_keeps_the_environment_that_a_bashrc_spoils(
    built: Workspace, tmp_path: pathlib.Path
) -> None:
    (tmp_path / ".bashrc").write_text("PATH=/spoilt:$PATH\nalias mine='echo alias'\n")
    terminal, child_side = pty.openpty()
    shell = subprocess.Popen(
        [str(built.root / "ci" / "exec")],
        env=built.environment({"HOME": str(tmp_path), "TERM": "dumb"}),
        stdin=child_side,
        stdout=subprocess.PIPE,
        stderr=child_side,
        start_new_session=True,
    )
    os.write(terminal, b"mine; type -t roscd; echo $PATH; exit 5\n")
    out = shell.communicate(timeout=60)[0].decode()
    os.close(terminal)
    os.close(child_side)
    assert shell.returncode == 5
    assert out.startswith("alias\n")
    assert "/usr/bin" in out and "/spoilt" not in out
    # Without rosbash, roscd is missing.
    has_roscd = any(pathlib.Path(rosbash).exists() for rosbash in ROSBASH)
    assert ("function\n" in out) == has_roscd


def test_without_a_terminal_the_shell_reads_commands(built: Workspace) -> None:
    assert built.run(stdin="echo $ROS_DISTRO; exit 4\n").returncode == 4


@pytest.mark.parametrize("words", [(), ("--port=1", "-p", "PORT")])
def test_master_of_another_user_is_refused_unless_it_is_chosen(
    built: Workspace, words: Sequence[str]
) -> None:
    owner = pwd.getpwuid(os.getuid()).pw_name
    with socket.create_server(("localhost", 0)) as listener:
        port = listener.getsockname()[1]
        built.be_somebody()
        built.fakes.update(HASTY_AWK)
        command = ["roslaunch", "--help"] if words else ["true"]
        command += [word.replace("PORT", str(port)) for word in words]
        changes = {"ROS_MASTER_URI": "" if words else f"http://localhost:{port}"}
        try:
            done = built.run(*command, **changes)
        finally:
            built.fakes.clear()
        line, *refusal = done.stderr.splitlines()
        if words:
            assert done.returncode == 125 and done.stdout == ""
            assert len(refusal) == 1 and "nothing was started" in refusal[0]
        else:
            assert (done.returncode, refusal) == (0, [])
        assert f"port {port} of this machine is used by {owner}" in line
        found = re.search("'export ROS_MASTER_URI=http://localhost:([0-9]+)'", line)
        assert found and int(found.group(1)) > port
        assert built.run("true", ROS_MASTER_URI=f"http://localhost:{port}").stderr == ""
    # Nothing listens there.
    built.be_somebody()
    try:
        assert built.run("true", ROS_MASTER_URI=f"http://localhost:{port}").stderr == ""
    finally:
        built.fakes.clear()
