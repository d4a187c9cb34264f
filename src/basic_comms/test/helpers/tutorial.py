"""Do what a page of the documentation tells its reader to do."""

import os
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Callable, Dict, List, Optional, Type

from nodekit.testing.console import INTERRUPT, Step, find, is_all, plain, steps_of

#: The root of the workspace, where a reader is.
WORKSPACE = Path(__file__).resolve().parents[4]


class PageError(AssertionError):
    """Something on the page is not as it says."""


class _Job:
    """A command that runs in a shell and leaves its output in a file."""

    def __init__(self, command: str, environment: Dict[str, str], output: Path) -> None:
        self._output = output
        #: Index in the output up to which it has been compared.
        self.seen = 0
        with output.open("wb") as file:
            self._process = subprocess.Popen(
                ["bash", "-c", command],
                cwd=WORKSPACE,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def status(self) -> Optional[int]:
        """Exit status, None while it runs."""
        return self._process.poll()

    def output(self) -> str:
        """Return what it has printed so far."""
        return plain(self._output.read_text(errors="replace"))

    def ended_by(self, deadline: float) -> bool:
        """Wait for its end.

        :param deadline: on the monotonic clock, s
        :returns: whether it has ended
        """
        try:
            self._process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            return False
        return True

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        os.killpg(self._process.pid, signal.SIGINT)

    def kill(self) -> None:
        """End it at once, if it runs."""
        if self.status is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()


class Reader:
    """Follows pages on a master of its own, in a home directory of its own.

    :param timeout: how long to wait for what the page shows, s; generous, as
        everything goes on at once when it is there
    """

    def __init__(self, timeout: float = 40.0) -> None:
        self._timeout = timeout
        self._home = tempfile.TemporaryDirectory()
        self._port, self._scope_port = _free_ports(2)
        self._environment = dict(
            os.environ,
            HOME=self._home.name,
            PYTHONUNBUFFERED="1",
            ROS_MASTER_URI=f"http://localhost:{self._port}",
            TERM="dumb",
        )
        self._terminals: Dict[str, _Job] = {}
        self._jobs: List[_Job] = []

    def __enter__(self) -> "Reader":
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        running = [job for job in reversed(self._jobs) if job.status is None]
        for job in running:
            job.interrupt()
            job.ended_by(time.monotonic() + self._timeout)
            job.kill()
        self._home.cleanup()

    def follow(self, page: str) -> int:
        """Do all steps of a page.

        :param page: the text of the page, Markdown
        :returns: how many steps there were
        :raises PageError: if one does not show what the page says
        """
        steps = steps_of(page)
        for step in steps:
            if step.terminal is None:
                self._run(step)
            elif step.typed == INTERRUPT:
                self._interrupt(step, step.terminal)
            else:
                self._watch(step, step.terminal)
        return len(steps)

    def _run(self, step: Step) -> None:
        """Run a command that ends; again, where the graph was not ready for it."""
        if step.typed is None or step.typed == INTERRUPT:
            raise _wrong(step, "there is nothing to type outside of a terminal", "")
        deadline = time.monotonic() + self._timeout
        tried: Optional[_Job] = None
        while tried is None or time.monotonic() < deadline:
            job = self._start(step.typed)
            if not job.ended_by(deadline):
                job.kill()
                tried = tried or job
                break
            tried = job
            # A failure is fine where the page shows it.
            if is_all(step.expected, job.output()) and (step.expected or job.status == 0):
                return
            time.sleep(0.1)
        raise _wrong(step, f"status {tried.status}", tried.output())

    def _watch(self, step: Step, terminal: str) -> None:
        """Start a command that keeps running, or not, and wait for what it prints."""
        if step.typed is not None:
            previous = self._terminals.get(terminal)
            if previous and not previous.ended_by(time.monotonic() + self._timeout):
                raise _wrong(step, f"{terminal} is busy", previous.output())
            self._terminals[terminal] = self._start(step.typed)
        job = self._job(step, terminal)
        self._wait_for(step, job, lambda: find(step.expected, job.output(), job.seen))

    def _interrupt(self, step: Step, terminal: str) -> None:
        job = self._job(step, terminal)
        if job.status is not None:
            raise _wrong(step, f"{terminal} has ended by itself", job.output())
        job.interrupt()
        if not job.ended_by(time.monotonic() + self._timeout):
            raise _wrong(step, f"{terminal} does not end", job.output())
        self._wait_for(step, job, lambda: find(step.expected, job.output(), job.seen))

    def _wait_for(self, step: Step, job: _Job, condition: Callable[[], Optional[int]]) -> None:
        deadline = time.monotonic() + self._timeout
        while True:
            last_chance = job.status is not None or time.monotonic() > deadline
            found = condition()
            if found is not None:
                job.seen = found
                return
            if last_chance:
                raise _wrong(step, f"status {job.status}", job.output()[job.seen :])
            time.sleep(0.05)

    def _job(self, step: Step, terminal: str) -> _Job:
        if terminal not in self._terminals:
            raise _wrong(step, f"nothing was started in {terminal}", "")
        return self._terminals[terminal]

    def _start(self, command: str) -> _Job:
        if command.split()[0] == "roscore":  # alone among the tools it ignores ROS_MASTER_URI
            command += f" -p {self._port}"
        if "topic_scope scope.py" in command:  # beside one that somebody may have open
            command += f" --port {self._scope_port}"
        output = Path(self._home.name, f"output{len(self._jobs)}")
        job = _Job(command, self._environment, output)
        self._jobs.append(job)
        return job


def _free_ports(count: int) -> List[int]:
    probes = [socket.socket() for _ in range(count)]
    for probe in probes:
        probe.bind(("localhost", 0))
    ports: List[int] = [probe.getsockname()[1] for probe in probes]
    for probe in probes:
        probe.close()
    return ports


def _wrong(step: Step, what: str, output: str) -> PageError:
    text = "line %d: %s\n%s\nexpected:\n%s\nseen:\n%s"
    expected = "\n".join(step.expected)
    return PageError(text % (step.line, step.typed or step.terminal, what, expected, output))
