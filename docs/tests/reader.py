"""Do what a page of the documentation tells its reader to do."""

import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, Iterable, List, Optional

from console_blocks import INTERRUPT, Instruction, find, instructions_of, is_all
from job import Job
from pages import WORKSPACE, environment_of_reader
from warm_python import WarmPython

from nodekit.testing.processes import free_ports

#: First and longest pause before a command is run again [s].
_SHORTEST_S, _LONGEST_S = 0.1, 1.0


class PageError(AssertionError):
    """Something on the page is not as it says."""


class Reader:
    """Follows pages on a master of its own, in a home directory of its own.

    :param timeout: how long to wait for what the page shows [s]; generous, as everything goes on at
        once when it is there. A command that ends may take longer: the rest of the limit
    :param limit: how long a page may take in all [s]
    :param python: runs the commands that are Python programs; without it, each is a new process
    :param new_process: beginnings of commands that are started as new processes even so
    """

    def __init__(
        self,
        timeout: float = 100.0,
        limit: float = 300.0,
        python: Optional[WarmPython] = None,
        new_process: Iterable[str] = (),
    ) -> None:
        self._python = python
        self._new_process = tuple(new_process)
        self._end = float("inf")
        self._timeout = timeout
        self._limit = limit
        self._home = tempfile.TemporaryDirectory()
        self._port, self._scope_port = free_ports(2)
        self._environment = environment_of_reader(
            COLUMNS="80",
            HOME=self._home.name,
            ROS_MASTER_URI=f"http://localhost:{self._port}",
            TERM="dumb",
        )
        self._terminals: Dict[str, Job] = {}
        self._jobs: List[Job] = []

    def __enter__(self) -> "Reader":
        return self

    def __exit__(self, *_error: object) -> None:
        running = [job for job in reversed(self._jobs) if job.status is None]
        for job in running:
            job.interrupt()
            job.ended_by(time.monotonic() + self._timeout)
            job.kill()
        self._home.cleanup()

    def follow(self, page: str) -> int:
        """Do all instructions of a page.

        :param page: the text of the page, Markdown
        :returns: how many instructions there were
        :raises PageError: if one does not show what the page says
        """
        instructions = instructions_of(page)
        self._end = time.monotonic() + self._limit
        for instruction in instructions:
            if time.monotonic() > self._end:
                raise self._too_long(instruction, "")
            if instruction.terminal is None:
                self._run(instruction)
            elif instruction.typed == INTERRUPT:
                self._interrupt(instruction, instruction.terminal)
            else:
                self._watch(instruction, instruction.terminal)
        return len(instructions)

    def _run(self, instruction: Instruction) -> None:
        """Run a command that ends; again, where the graph was not ready for it."""
        if instruction.typed is None or instruction.typed == INTERRUPT:
            raise _wrong(instruction, "there is nothing to type outside of a terminal", "")
        deadline = time.monotonic() + self._timeout
        tried: Optional[Job] = None
        pause = _SHORTEST_S
        while tried is None or time.monotonic() < deadline:
            job = self._start(instruction.typed, goes_on=False)
            if not job.ended_by(self._end):
                job.kill()
                raise self._too_long(instruction, (tried or job).output())
            tried = job
            # A failure is fine where the page shows it.
            if is_all(instruction.expected, job.output()) and (
                instruction.expected or job.status == 0
            ):
                return
            time.sleep(pause)
            pause = min(2.0 * pause, _LONGEST_S)
        raise _wrong(instruction, f"status {tried.status}", tried.output())

    def _watch(self, instruction: Instruction, terminal: str) -> None:
        """Start a command that keeps running, or not, and wait for what it prints."""
        if instruction.typed is not None:
            previous = self._terminals.get(terminal)
            if previous and not previous.ended_by(time.monotonic() + self._timeout):
                raise _wrong(instruction, f"{terminal} is busy", previous.output())
            self._terminals[terminal] = self._start(instruction.typed, goes_on=True)
        job = self._job(instruction, terminal)
        self._wait_for(instruction, job, lambda: find(instruction.expected, job.output(), job.seen))

    def _interrupt(self, instruction: Instruction, terminal: str) -> None:
        job = self._job(instruction, terminal)
        if job.status is not None:
            raise _wrong(instruction, f"{terminal} has ended by itself", job.output())
        job.interrupt()
        if not job.ended_by(time.monotonic() + self._timeout):
            raise _wrong(instruction, f"{terminal} does not end", job.output())
        self._wait_for(instruction, job, lambda: find(instruction.expected, job.output(), job.seen))

    def _wait_for(
        self, instruction: Instruction, job: Job, condition: Callable[[], Optional[int]]
    ) -> None:
        deadline = time.monotonic() + self._timeout
        while True:
            last_chance = job.status is not None or time.monotonic() > deadline
            found = condition()
            if found is not None:
                job.seen = found
                return
            if last_chance:
                raise _wrong(instruction, f"status {job.status}", job.output()[job.seen :])
            time.sleep(0.05)

    def _too_long(self, instruction: Instruction, output: str) -> PageError:
        return _wrong(instruction, f"the page takes longer than {self._limit:g} s", output)

    def _job(self, instruction: Instruction, terminal: str) -> Job:
        if terminal not in self._terminals:
            raise _wrong(instruction, f"nothing was started in {terminal}", "")
        return self._terminals[terminal]

    def _start(self, command: str, goes_on: bool) -> Job:
        if command.split()[0] == "roscore":  # alone among the tools it ignores ROS_MASTER_URI
            command += f" -p {self._port}"
        if "topic_scope scope.py" in command:  # the user may have another one open
            command += f" --port {self._scope_port}"
        output = Path(self._home.name, f"output{len(self._jobs)}")
        python = None if command.startswith(self._new_process) else self._python
        job = Job(command, WORKSPACE, self._environment, output, goes_on, python)
        self._jobs.append(job)
        return job


def _wrong(instruction: Instruction, what: str, output: str) -> PageError:
    text = "line %d: %s\n%s\nexpected:\n%s\nseen:\n%s"
    expected = "\n".join(instruction.expected)
    return PageError(
        text % (instruction.line, instruction.typed or instruction.terminal, what, expected, output)
    )
