"""Runner of one step of the tests, a command, and parser of its results."""

import contextlib
import dataclasses
import json
import os
import pathlib
import random
import signal
import socket
import subprocess
import time
from typing import Dict, List, Mapping, Optional, Sequence, Set
from xml.etree import ElementTree

from .workspace import WORKSPACE

# Time for a command to clean up after its time limit [s].
GRACE = 30.0
# Interval of the checks whether a command has ended [s].
POLL_S = 0.05
#: Ports for masters, as in nodekit.testing.processes: a step may start its master minutes later.
_PORTS = range(12_000, 32_768)
#: File that a step may write to its results: duration of each of its test files [s].
PLACES = "places.json"
#: Longest reason of a failure in the report [characters].
_LONGEST_REASON = 400


@dataclasses.dataclass(frozen=True)
class Step:
    """A command to run for a tier.

    ``{results}`` in an argument is the directory for JUnit files. A command without JUnit files is
    one test. ``after`` names a step of the same tier that must run first. Steps that measure in
    real time run ``alone``.

    ``repeat`` holds the arguments of ``ci/test`` that run a single test again: ``{file}`` is the
    name of the JUnit file up to its first dot, ``{case}`` the test's name, and ``{module}`` the
    file of a pytest test.
    """

    tier: str
    name: str
    command: List[str]
    time_limit: float = 300.0  # s
    writes_junit: bool = False
    after: str = ""
    alone: bool = False
    repeat: str = ""

    @property
    def title(self) -> str:
        """Tier and name."""
        return f"{self.tier}/{self.name}"


@dataclasses.dataclass(frozen=True)
class Case:
    """A test case and its outcome."""

    name: str
    outcome: str  # passed, failed or skipped
    reason: str = ""
    class_name: str = ""
    file: str = ""  # of JUnit, its name up to the first dot


@dataclasses.dataclass(frozen=True)
class StepResult:
    """Test cases, times and output of a step."""

    step: Step
    cases: Sequence[Case]
    seconds: float
    cpu_seconds: float  # of the command and of all that it has waited for
    log: str
    places: Mapping[str, float] = dataclasses.field(default_factory=dict)  # seconds of each file

    @property
    def passed(self) -> int:
        return self._count("passed")

    @property
    def failed(self) -> int:
        return self._count("failed")

    @property
    def skipped(self) -> int:
        return self._count("skipped")

    def _count(self, outcome: str) -> int:
        return sum(case.outcome == outcome for case in self.cases)

    @property
    def good(self) -> bool:
        return self.passed == len(self.cases) > 0


class Runner:
    """Runner of steps, each with its own directory. Thread-safe."""

    def __init__(self) -> None:
        self._running: Set["subprocess.Popen[bytes]"] = set()
        self._interrupted = False

    def run(self, step: Step, directory: pathlib.Path) -> StepResult:
        """Run a step to its end or to its time limit."""
        results, scratch, log = directory / "results", directory / "tmp", directory / "log"
        results.mkdir(parents=True)
        scratch.mkdir()
        began = time.monotonic()
        with log.open("wb") as output:
            process = subprocess.Popen(
                # Ignored under nohup, which the step's processes would inherit.
                ["env", "--default-signal=HUP"]
                + [argument.replace("{results}", str(results)) for argument in step.command],
                cwd=str(WORKSPACE),
                env=environment(directory),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            self._running.add(process)
            cpu_seconds = 0.0
            if self._interrupted:  # maybe before this process was added
                stop(process)
            try:
                cpu_seconds = wait_and_measure(process, step.time_limit)
                status = process.returncode
            except subprocess.TimeoutExpired:
                output.write(b"\nstopped: it took more than %d s\n" % step.time_limit)
                status = -1
            stop(process)
            self._running.discard(process)
            end_leftovers(directory)
        seconds = time.monotonic() - began
        return result_of(step, status, results, seconds, cpu_seconds, log)

    def interrupt(self) -> None:
        """End the running or starting steps soon."""
        self._interrupted = True
        for process in list(self._running):
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.killpg(process.pid, signal.SIGINT)


def wait_and_measure(process: "subprocess.Popen[bytes]", limit: float) -> float:
    """Wait until a process has ended, and set its return code.

    :param limit: longest wait [s]
    :returns: processor time of the process and its collected children [s]
    :raises subprocess.TimeoutExpired: if it has not ended in time
    """
    deadline = time.monotonic() + limit
    while True:
        # In microseconds: each of the four times in /proc is rounded down to a tick of 10 ms.
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        if time.monotonic() > deadline:
            raise subprocess.TimeoutExpired(process.args, limit)
        time.sleep(POLL_S)
    signalled = os.WIFSIGNALED(status)
    process.returncode = -os.WTERMSIG(status) if signalled else os.WEXITSTATUS(status)
    return usage.ru_utime + usage.ru_stime


def result_of(
    step: Step,
    status: int,
    results: pathlib.Path,
    seconds: float,
    cpu_seconds: float,
    log: pathlib.Path,
) -> StepResult:
    """Return a step's tests; a bad status, or no test at all, adds a failure."""
    text = log.read_text(errors="replace")
    cases = read_cases(results)
    if not step.writes_junit and status == 0:
        cases = [Case(step.name, "passed")]
    failed = any(case.outcome == "failed" for case in cases)
    if status != 0 and not failed:
        cases.append(Case(step.name, "failed", f"ended with status {status}"))
        text += f"\nended with status {status}\n"
    if not cases:
        cases = [Case(step.name, "failed", "no test ran")]
        text += "\nno test ran\n"
    places = {}
    if (results / PLACES).exists():
        places = json.loads((results / PLACES).read_text("utf-8"))
    return StepResult(step, cases, seconds, cpu_seconds, text, places)


def free_port() -> int:
    """Return a free port outside the system's ephemeral range."""
    while True:
        with contextlib.suppress(OSError), socket.socket() as probe:
            probe.bind(("localhost", random.SystemRandom().choice(_PORTS)))
            return int(probe.getsockname()[1])


def environment(directory: pathlib.Path) -> Dict[str, str]:
    """Return the environment of a step, with its own master port and folders."""
    variables = dict(
        os.environ,
        ROS_MASTER_URI=f"http://localhost:{free_port()}",
        ROS_HOME=str(directory / "ros"),
        ROS_LOG_DIR=str(directory / "ros" / "log"),
        TMPDIR=str(directory / "tmp"),
        HYPOTHESIS_STORAGE_DIRECTORY=str(directory / "hypothesis"),
    )
    # Users set neither. The first makes each of hundreds of nodes compile its modules; the second
    # hides that output stays in a buffer.
    for name in ("PYTHONDONTWRITEBYTECODE", "PYTHONUNBUFFERED"):
        variables.pop(name, None)
    return variables


def stop(process: "subprocess.Popen[bytes]") -> None:
    """End a command if it still runs, with time to end its own children."""
    for number in (signal.SIGINT, signal.SIGKILL):
        if process.poll() is None:
            os.killpg(process.pid, number)
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                continue


def end_leftovers(directory: pathlib.Path) -> None:
    """Kill the remaining processes of a step.

    roslaunch starts every node in its own session, outside the step's process group; they are
    found by the step's ROS_HOME.
    """
    mark = b"ROS_HOME=%s" % os.fsencode(directory / "ros")
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)
        except OSError:
            continue  # ended meanwhile, or another user's


def read_cases(results: pathlib.Path) -> List[Case]:
    """Return the test cases in the JUnit files below a directory.

    rostest writes a file for each test node, and a file about running them; the cases of the latter
    are returned only for nodes that failed to report.
    """
    cases: List[Case] = []
    for path in sorted(results.rglob("*.xml")):
        try:
            elements = list(ElementTree.parse(str(path)).getroot().iter("testcase"))
        except ElementTree.ParseError:
            cases.append(Case(path.name, "failed", "not a JUnit file"))
            continue
        file = path.name.partition(".")[0]
        for element in elements:
            name, class_name = element.get("name", "a test"), element.get("classname", "")
            defects = element.findall("failure") + element.findall("error")
            if defects:
                why = reason_of(defects[0])
                cases.append(Case(name, "failed", why, class_name, file))
            elif element.find("skipped") is not None:
                cases.append(Case(name, "skipped", "", class_name, file))
            elif not path.name.startswith("rostest-"):
                cases.append(Case(name, "passed", "", class_name, file))
    return cases


def reason_of(defect: ElementTree.Element) -> str:
    """Return the reason of a failure in one line, without its traceback."""
    said = defect.get("message") or defect.text or ""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    trace = next((i for i, line in enumerate(lines) if line.startswith("File ")), None)
    return " ".join(lines[:trace])[:_LONGEST_REASON]


def repeat_command(step: Step, case: Case) -> str:
    """Return the command that repeats one test of a step, or the whole step."""
    if not step.repeat:
        return f"./ci/test {step.tier}"
    module = module_of(case.class_name)
    if "{module}" in step.repeat and module is None:
        return f"./ci/test {step.tier}"
    return "./ci/test " + step.repeat.format(file=case.file, case=case.name, module=module)


def module_of(class_name: str) -> Optional[str]:
    """Return the file of a pytest case: ``src.a.test.unit.test_b.TestC`` names test_b.py."""
    parts = class_name.split(".") if class_name else []
    for count in range(len(parts), 0, -1):
        path = pathlib.Path(*parts[:count]).with_suffix(".py")
        if (WORKSPACE / path).is_file():
            return str(path)
    return None
