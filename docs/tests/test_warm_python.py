"""A warm program is a process like any other: its arguments, output, signals and exit status."""

import itertools
import signal
from pathlib import Path
from typing import Callable, List

import pytest
from job import Job, expanded, python_program
from pages import environment_of_reader
from warm_python import Program, WarmPython

from nodekit.testing.waiting import wait_until

ENVIRONMENT = environment_of_reader(HOME="/home/reader", NAME="value")
TIMEOUT_S = 30.0

Starter = Callable[..., Job]


@pytest.fixture
def start(tmp_path: Path, python: WarmPython) -> Starter:
    """Return a function that starts a program, given its text and its arguments."""
    outputs = map(str, itertools.count())

    def start(text: str, *arguments: str, goes_on: bool = False, warm: bool = True) -> Job:
        # Replaced, not rewritten: the program before it may still have to be read.
        written, program = tmp_path / "written.py", tmp_path / "program.py"
        written.write_text("#!/usr/bin/env python3\n" + text)
        written.chmod(0o755)
        written.replace(program)
        command = " ".join(["./program.py", *arguments])
        server = python if warm else None
        return Job(command, tmp_path, ENVIRONMENT, tmp_path / next(outputs), goes_on, server)

    return start


def status_of(job: Job) -> int:
    wait_until(lambda: job.status is not None, lambda: "it does not end", TIMEOUT_S)
    assert job.status is not None
    return job.status


FACTS = """
import atexit, os, signal, sys, threading
atexit.register(print, "at exit")
print(__name__, sys.argv[1:], os.getcwd() == sys.path[0], os.environ["NAME"], __file__[-10:])
print(sys.stdin.read(), os.getsid(0) == os.getpgid(0) == os.getpid())
print(sorted(os.listdir("/proc/self/fd")))
print(signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGCHLD), sys.stdout.line_buffering)
print(threading.current_thread().name, threading.active_count())
sys.stderr.write("error\\n")
threading.Timer(0.1, print, ["thread"]).start()
"""


@pytest.mark.parametrize("goes_on", [False, True])
def test_surroundings_are_those_of_a_cold_program(start: Starter, goes_on: bool) -> None:
    outputs = []
    for warm in (True, False):
        job = start(FACTS, "a", '"b  c"', "~/d", "$NAME", "# e", goes_on=goes_on, warm=warm)
        assert status_of(job) == 0
        outputs.append(job.output())
    assert "['a', 'b  c', '/home/reader/d', 'value'] True value" in outputs[0]
    assert outputs[0].endswith("thread\nat exit\n")
    assert outputs[0] == outputs[1]


NAMES = """
import rospy
print(rospy.get_name(), rospy.get_namespace(), rospy.resolve_name("a"), rospy.names.get_mappings())
"""


@pytest.mark.parametrize("arguments", [[], ["__ns:=b"], ["a:=c", "_d:=e"], ["__name:=f"]])
@pytest.mark.parametrize("namespace", ["", "g"])
def test_names_are_those_of_a_cold_program(
    start: Starter, monkeypatch: pytest.MonkeyPatch, arguments: List[str], namespace: str
) -> None:
    monkeypatch.setitem(ENVIRONMENT, "ROS_NAMESPACE", namespace)
    warm, cold = start(NAMES, *arguments), start(NAMES, *arguments, warm=False)
    assert status_of(warm) == status_of(cold) == 0
    assert warm.output() == cold.output()


@pytest.mark.parametrize(
    "text",
    [
        "raise SystemExit",
        "raise SystemExit(7)",
        "raise SystemExit(-1)",
        "raise SystemExit('a reason')",
        "import sys; sys.exit(True)",
        "1 / 0",
        "raise KeyboardInterrupt",
        "import os; os._exit(3)",
        "import os; os.kill(os.getpid(), 9)",
        "import os; os.abort()",
        "def",
    ],
)
def test_status_is_that_of_a_cold_program(start: Starter, text: str) -> None:
    warm, cold = start(text), start(text, warm=False)
    assert status_of(warm) == status_of(cold)


def test_interrupt_ends_a_program_at_once(start: Starter) -> None:
    text = "import time\ntry: print('on'), time.sleep(60)\nfinally: print('off')"
    job = start(text, goes_on=True)
    wait_until(lambda: job.output() == "on\n", job.output, TIMEOUT_S)
    job.interrupt()
    assert status_of(job) == -signal.SIGINT
    assert "off\nTraceback" in job.output() and "KeyboardInterrupt" in job.output()


def test_terminal_shows_a_line_while_the_program_runs_and_a_file_keeps_it_back(
    start: Starter, tmp_path: Path
) -> None:
    text = "import time, pathlib\nprint('on')\npathlib.Path('written').touch()\ntime.sleep(60)"
    for goes_on, shown in ((True, "on\n"), (False, "")):
        job = start(text, goes_on=goes_on)
        wait_until((tmp_path / "written").exists, lambda: "it does not run", TIMEOUT_S)
        (tmp_path / "written").unlink()
        if shown:
            wait_until(lambda: job.output() == shown, job.output, TIMEOUT_S)
        assert job.output() == shown
        job.kill()
        assert status_of(job) == -signal.SIGKILL


def test_program_that_has_ended_keeps_its_id_until_its_status_is_read(
    python: WarmPython, start: Starter, tmp_path: Path
) -> None:
    job = start("import pathlib; pathlib.Path('pid').write_text(str(__import__('os').getpid()))")
    pid = tmp_path / "pid"
    wait_until(lambda: pid.exists() and pid.read_text(), lambda: "it does not run", TIMEOUT_S)
    state = Path("/proc", pid.read_text(), "stat")
    wait_until(lambda: ") Z" in state.read_text(), state.read_text, TIMEOUT_S)
    job.interrupt()
    assert status_of(job) == 0
    wait_until(lambda: not state.exists(), lambda: "it stays", TIMEOUT_S)


def test_output_that_was_written_last_is_there_when_the_program_has_ended(start: Starter) -> None:
    job = start("print('x' * 1_000_000)", goes_on=True)
    assert status_of(job) == 0
    assert len(job.output()) == 1_000_001


def test_roslaunch_takes_from_commands_what_a_cold_one_takes(
    tmp_path: Path, python: WarmPython
) -> None:
    commands = ["rosversion roslaunch", "rosversion -d", "printf b", "no_such_command", "false"]
    outputs = []
    for count, command in enumerate(commands):
        (tmp_path / "a.launch").write_text(
            f'<launch><param name="a" command="{command}"/></launch>'
        )
        for server in (python, None):
            output = tmp_path / f"{count}{server}".replace("/", "_")
            line = "roslaunch --dump-params ./a.launch"
            job = Job(line, tmp_path, ENVIRONMENT, output, False, server)
            outputs.append((status_of(job), job.output().strip()))
    assert outputs[::2] == outputs[1::2]
    assert outputs[4] == (0, "/a: b") and outputs[0] != outputs[2]
    assert "no such command" in outputs[6][1] and "returned with code [1]" in outputs[8][1]


def test_program_that_cannot_be_started_is_reported(python: WarmPython, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="could not be started"):
        python.start(
            Program(["a.py"], str(tmp_path / "none"), ENVIRONMENT, "/dev/null", "/dev/null")
        )


@pytest.mark.parametrize(
    "command, words",
    [
        ("a 'b c' \"$NAME\"  # d", ["a", "b c", "value"]),
        ("a '{b: [1]}' ~/c", ["a", "{b: [1]}", "/home/reader/c"]),
        ("a | b", []),
        ("a & b", []),
        ("a; b", []),
        ("a > b", []),
        ("a $(b)", []),
        ("a `b`", []),
        ("NAME=b a", []),
        ("for i in 1; do a; done", []),
    ],
)
def test_only_a_simple_command_has_words(command: str, words: List[str]) -> None:
    assert expanded(command, Path("/"), ENVIRONMENT) == words


@pytest.mark.parametrize(
    "words, program",
    [
        (["rostopic", "list"], "/rostopic"),
        (["roslaunch", "basic_comms", "cw1.launch", "ns:=a"], "/roslaunch"),
        (["rosrun", "basic_comms", "talker.py", "_rate:=2"], "/basic_comms/talker.py"),
        (["rosrun", "--prefix", "nice", "basic_comms", "talker.py"], None),
        (["rosrun", "basic_comms", "nothing.py"], None),
        (["rosrun", "no_such_package", "talker.py"], None),
        (["rosrun"], None),
        (["ls"], None),
        (["no_such_program"], None),
        ([], None),
    ],
)
def test_program_is_found_as_ros_finds_it(words: List[str], program: str) -> None:
    found = python_program(words, Path("/"), ENVIRONMENT)
    assert found[0].endswith(program) if program else not found, found
    if words[:1] == ["rosrun"] and found:
        assert found[1:] == words[3:]
