"""Tests of finding the exception that ended a controller, in the output of real programs."""

import os
import pathlib
import shutil
import sys
from typing import List

import pytest

from nodekit.testing.waiting import wait_until
from pid_control.programs import program_process
from pid_control.programs.program_command import ProgramCommand
from pid_control.programs.program_process import ProgramProcess
from pid_control.programs.python_crash import crash_in

#: A student's template: it prints a line at its end, whatever happens.
TEMPLATE = """import sys
from gains import gain
try:
    print(gain(sys.argv[1]))
{handler}
"""
GAINS = """import json
def gain(text):
    return json.loads(text)["kp"]
"""
FINALLY = "finally:\n    print('Stopping')"
CATCHES = "except Exception:\n    import traceback\n    traceback.print_exc()\nprint('Stopping')"
#: catkin's wrapper in devel/lib for a Python program.
RELAY = "exec(compile(open({path!r}).read(), {path!r}, 'exec'))\n"


@pytest.fixture
def package(tmp_path: pathlib.Path) -> pathlib.Path:
    """Folder of a student's package, below which are a controller and a module."""
    scripts = tmp_path / "anna" / "scripts"
    scripts.mkdir(parents=True)
    (tmp_path / "anna" / "package.xml").write_text("<package><name>anna</name></package>")
    (scripts / "controller.py").write_text(TEMPLATE.format(handler=FINALLY))
    (scripts / "gains.py").write_text(GAINS)
    return tmp_path / "anna"


def last_words(*words: str, **environment: str) -> str:
    """Return the last words of a program that has ended."""
    argv = [sys.executable, *words]
    command = ProgramCommand("x", argv, {**os.environ, **environment}, {}, {})
    controller = ProgramProcess(command, {})
    try:
        wait_until(lambda: controller.status is not None, controller.last_words)
        return controller.last_words()
    finally:
        controller.end()


@pytest.mark.parametrize("handler", [FINALLY, CATCHES])
@pytest.mark.parametrize(
    "gain, says",
    [
        ("{}", "KeyError: 'kp' (gains.py, line 3)"),
        (
            "x",
            "json.decoder.JSONDecodeError: Expecting value: line 1 column 1 (char 0)"
            " (gains.py, line 3)",
        ),
        ('{"kp": 1}', "Stopping"),
    ],
)
def test_last_words_of_crash_are_exception_and_own_line(
    handler: str, gain: str, says: str, package: pathlib.Path
) -> None:
    program = package / "scripts" / "controller.py"
    program.write_text(TEMPLATE.format(handler=handler))
    assert last_words(str(program), gain) == says


def test_last_words_of_built_package_name_its_source(
    package: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    scripts = package / "scripts"
    program = tmp_path / "devel" / "lib" / "anna" / "controller.py"
    program.parent.mkdir(parents=True)
    program.write_text(RELAY.format(path=str(scripts / "controller.py")))
    words = last_words(str(program), "{}", PYTHONPATH=str(scripts))
    assert words == "KeyError: 'kp' (gains.py, line 3)"
    # A module in another folder of the package is the student's too.
    (package / "src" / "anna").mkdir(parents=True)
    (scripts / "gains.py").rename(package / "src" / "anna" / "gains.py")
    words = last_words(str(program), "{}", PYTHONPATH=str(package / "src" / "anna"))
    assert words == "KeyError: 'kp' (gains.py, line 3)"


def test_last_words_of_program_without_package_name_its_folder_only(
    package: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    program = tmp_path / "controller.py"
    shutil.copy(str(package / "scripts" / "controller.py"), str(program))
    words = last_words(str(program), "{}", PYTHONPATH=str(package / "scripts"))
    assert words == "KeyError: 'kp' (controller.py, line 4)"


def test_last_words_of_running_program_are_its_last_line_however_much_it_writes(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(program_process, "_TOO_MUCH", 200_000)
    descriptors = len(os.listdir("/proc/self/fd"))
    text = """import os, sys, time
for _ in range(30):
    print("x" * 10_000)
print('  File "a.py", line 1\\nKeyError: 9\\n' + os.environ["WHO"], flush=True)
time.sleep(60)
"""
    command = ProgramCommand("x", [sys.executable, "-c", text], {"WHO": "command"}, {}, {})
    controller = ProgramProcess(command, {"WHO": "judge"})
    try:
        wait_until(lambda: controller.last_words() == "judge", controller.last_words)
        assert controller.writes_without_end
    finally:
        controller.end()
        controller.watch.close()
    assert controller.status is not None
    assert len(os.listdir("/proc/self/fd")) <= descriptors


FRAME = '  File "{path}", line {line}\n'


@pytest.mark.parametrize(
    "lines, says",
    [
        (["Stopping\n"], ""),
        (["ValueError: not after a traceback\n"], ""),
        (
            [FRAME, "    foo(\n", "SyntaxError: '(' was never closed\n"],
            "SyntaxError: '(' was never closed",
        ),
        ([FRAME, "[INFO] between\n", "KeyError: 9\n", "Stopping\n"], "KeyError: 9"),
        ([FRAME, "KeyError: 9\n", "\n", FRAME, "KeyboardInterrupt\n"], "KeyboardInterrupt"),
    ],
)
def test_crash_in_returns_latest_exception(
    lines: List[str], says: str, package: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    program = str(package / "scripts" / "controller.py")
    output = "".join(lines).format(path=program, line=7)
    place = " (controller.py, line 7)" if says else ""
    assert crash_in(output, [program]) == says + place
    # Neither is a frame of the interpreter itself, wherever this process runs.
    monkeypatch.chdir(package / "scripts")
    for inner in ("<frozen runpy>", "<string>"):
        frames = FRAME.format(path=program, line=5) + FRAME.format(path=inner, line=7)
        lines_of = "".join(lines).replace(FRAME, frames)
        assert crash_in(lines_of, [program]) == says + place.replace("7", "5")
    for place in ("/usr/lib/python3/dist-packages", f"{package}/venv/lib/site-packages"):
        installed = output.replace(program, f"{place}/rospy/core.py")
        assert crash_in(installed, [program]) == says


def test_last_words_of_a_program_that_goes_on_are_an_exception_until_it_says_more(
    tmp_path: pathlib.Path,
) -> None:
    program, go_on = tmp_path / "controller.py", tmp_path / "go_on"
    program.write_text(
        "import os, time, traceback\n"
        "try:\n"
        "    1 / 0\n"
        "except ZeroDivisionError:\n"
        "    traceback.print_exc()\n"
        f"while not os.path.exists({str(go_on)!r}):\n"
        "    time.sleep(0.01)\n"
        "print('all is well', flush=True)\n"
        "time.sleep(60)\n"
    )
    command = ProgramCommand("x", [sys.executable, str(program)], dict(os.environ), {}, {})
    controller = ProgramProcess(command, {})
    says = "ZeroDivisionError: division by zero (controller.py, line 3)"
    try:
        wait_until(lambda: controller.last_words() == says, controller.last_words)
        go_on.touch()
        wait_until(lambda: controller.last_words() == "all is well", controller.last_words)
    finally:
        controller.end()
