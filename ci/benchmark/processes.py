"""Processes with their logs, and a ROS master with the processes that use it."""

import contextlib
import os
import pathlib
import signal
import subprocess
import time
from typing import Dict, Iterator, List, Optional, TypeVar

import rosgraph
from nodekit.testing.processes import free_port

from ..tiers.steps import end_leftovers
from .peer_programs import SCRIPTS, WORKSPACE
from .recorder import Recorder, wait_until

#: Time for a node to settle after its registration [s].
SETTLED = 1.5
#: Longest time for a process to end after Ctrl-C [s].
PATIENCE_S = 10.0


Own = TypeVar("Own", bound="Processes")


class Processes:
    """Processes with logs in one directory; all end together.

    :param directory: an empty directory for logs and files
    """

    def __init__(self, directory: pathlib.Path) -> None:
        self.directory = directory
        self.environment: Dict[str, str] = dict(
            os.environ,
            ROS_HOME=str(directory / "ros"),
            ROS_LOG_DIR=str(directory / "ros" / "log"),
        )
        self.running: List["subprocess.Popen[bytes]"] = []
        self._logs: Dict[int, pathlib.Path] = {}

    def __enter__(self: Own) -> Own:
        try:
            self.prepare()
        except BaseException:
            self.end_all()
            raise
        return self

    def __exit__(self, *_error: object) -> None:
        self.end_all()

    def prepare(self) -> None:
        """Start the processes that all others need."""

    def start(
        self,
        command: List[str],
        environment: Optional[Dict[str, str]] = None,
        has_pipes: bool = False,
    ) -> "subprocess.Popen[bytes]":
        """Start a process in its own process group.

        :param environment: in place of this object's
        :param has_pipes: whether its standard input and output are pipes
        """
        name = f"{len(self._logs):03}-{pathlib.Path(command[0]).name}.log"
        with (self.directory / name).open("wb") as log:
            process = subprocess.Popen(
                command,
                env=environment or self.environment,
                stdin=subprocess.PIPE if has_pipes else subprocess.DEVNULL,
                stdout=subprocess.PIPE if has_pipes else log,
                stderr=log,
                cwd=str(self.directory),
                start_new_session=True,
            )
        self.running.append(process)
        self._logs[process.pid] = self.directory / name
        return process

    def log_of(self, process: "subprocess.Popen[bytes]") -> str:
        """Return the output of a process so far."""
        return self._logs[process.pid].read_text(errors="replace")

    def logs(self) -> List[str]:
        """Return the texts of all logs, including those of ROS."""
        return [
            path.read_text(errors="replace")
            for path in sorted(self.directory.rglob("*.log"))
            if not path.is_symlink() and "latest" not in path.parts
        ]

    def stop(self, *processes: "subprocess.Popen[bytes]") -> None:
        """End processes by Ctrl-C; kill them if they take too long."""
        for number in (signal.SIGINT, signal.SIGKILL):
            remaining = [process for process in processes if process.poll() is None]
            for process in remaining:
                os.killpg(process.pid, number)
            deadline = time.monotonic() + PATIENCE_S
            for process in remaining:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(max(0.0, deadline - time.monotonic()))
        for process in processes:
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    pipe.close()
            if process in self.running:
                self.running.remove(process)

    def end_all(self) -> None:
        """End all processes, the first one last."""
        self.stop(*self.running[1:])
        self.stop(*self.running)
        end_leftovers(self.directory)


class Session(Processes):
    """A master on a free port, and the processes that use it.

    :ivar master: the Master API
    """

    def __init__(self, directory: pathlib.Path) -> None:
        super().__init__(directory)
        self._port, self._recorders = free_port(), 0
        self.master_uri = f"http://localhost:{self._port}"
        self.master = rosgraph.Master("/benchmark", self.master_uri)
        packages = [str(SCRIPTS / "course"), os.environ.get("ROS_PACKAGE_PATH", "")]
        self.environment.update(
            ROS_MASTER_URI=self.master_uri,
            ROS_HOSTNAME="localhost",
            ROS_PACKAGE_PATH=os.pathsep.join(packages),
            PYTHONPATH=os.pathsep.join([str(WORKSPACE), os.environ.get("PYTHONPATH", "")]),
        )
        self.environment.pop("ROS_IP", None)
        # Otherwise each start compiles the workspace's own modules.
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)

    def prepare(self) -> None:
        """Start the master."""
        self.start(["roscore", "-p", str(self._port)])
        wait_until(lambda: self._is_registered("/rosout"), 30.0, "answer from the master")

    def _is_registered(self, name: str) -> bool:
        with contextlib.suppress(OSError, rosgraph.MasterException):
            return f"'{name}'" in str(self.master.getSystemState())
        return False

    def record(self, topic: str, type_name: str) -> Recorder:
        """Return a recorder of a topic, for use as a context."""
        self._recorders += 1
        return Recorder(f"/recorder_{self._recorders}", self.master_uri, topic, type_name)

    def wait_for(self, name: str) -> None:
        """Wait until a node is registered, and has settled.

        :param name: global name
        """
        wait_until(lambda: self._is_registered(name), 30.0, "registration of " + name)
        time.sleep(SETTLED)

    def in_group(self, group: str) -> Dict[str, str]:
        """Return the environment of processes in a namespace."""
        return dict(self.environment, ROS_NAMESPACE=group)

    @contextlib.contextmanager
    def up(
        self, *commands: List[str], environment: Optional[Dict[str, str]] = None
    ) -> Iterator[List[int]]:
        """Run processes for the duration of the context.

        :param environment: in place of the session's own
        :returns: their process ids
        """
        processes: List["subprocess.Popen[bytes]"] = []
        try:
            for command in commands:
                processes.append(self.start(command, environment))
            yield [process.pid for process in processes]
        finally:
            self.stop(*reversed(processes))


@contextlib.contextmanager
def paused(pids: List[int]) -> Iterator[None]:
    """Stop processes for the duration of the context.

    :param pids: receivers before senders: sent data is still received
    """
    _pause(pids)
    try:
        yield
    finally:
        _resume(pids)  # a stopped process cannot end


@contextlib.contextmanager
def resumed(pids: List[int]) -> Iterator[None]:
    """Let stopped processes run for the duration of the context.

    :param pids: as for :func:`paused`
    """
    _resume(pids)
    try:
        yield
    finally:
        _pause(pids)


#: Time for sent data to arrive before the receiver is stopped [s].
DRAIN_S = 0.05


def _pause(pids: List[int]) -> None:
    for number, pid in enumerate(reversed(pids)):
        if number:
            time.sleep(DRAIN_S)
        os.kill(pid, signal.SIGSTOP)


def _resume(pids: List[int]) -> None:
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)
