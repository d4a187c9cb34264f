"""A ROS master of the benchmark's own, the processes started on it, and what they cost."""

import contextlib
import os
import pathlib
import signal
import socket
import subprocess
import time
from types import TracebackType
from typing import Dict, Iterable, Iterator, List, Optional, Type

from observers import wait_until
from peers import HERE, SCRIPTS
from steps import end_leftovers
from tcpros import Node

#: how long a process may take to end when asked to, s
PATIENCE = 5.0


class Session:
    """A master on a free port; what was started on it ends with it.

    :param directory: for logs and files; a fresh one
    """

    def __init__(self, directory: pathlib.Path) -> None:
        self.directory = directory
        with socket.socket() as probe:
            probe.bind(("localhost", 0))
            self._port = probe.getsockname()[1]
        self.master_uri = "http://localhost:%d" % self._port
        self.environment = dict(
            os.environ,
            ROS_MASTER_URI=self.master_uri,
            ROS_HOSTNAME="localhost",
            ROS_HOME=str(directory / "ros"),
            ROS_LOG_DIR=str(directory / "ros" / "log"),
            ROS_PACKAGE_PATH=os.pathsep.join(
                [str(SCRIPTS / "course"), os.environ.get("ROS_PACKAGE_PATH", "")]
            ),
            PYTHONPATH=os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")]),
        )
        self.environment.pop("ROS_IP", None)
        self._running: List["subprocess.Popen[bytes]"] = []
        self._numbers = 0

    def __enter__(self) -> "Session":
        try:
            self.start(["roscore", "-p", str(self._port)])
            self._wait_for_master()
        except BaseException:
            self._end_all()
            raise
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self._end_all()

    def _wait_for_master(self) -> None:
        def answers() -> bool:
            with contextlib.suppress(OSError), self.node() as node:
                return "/rosout" in dict(node.master("getTopicTypes"))
            return False

        wait_until(answers, 30.0, "answer from the master")

    def _end_all(self) -> None:
        for process in reversed(self._running):
            self.stop(process)
        end_leftovers(self.directory)

    @contextlib.contextmanager
    def node(self) -> Iterator[Node]:
        """Lend a node to measure with."""
        self._numbers += 1
        node = Node("/benchmark_%d" % self._numbers, self.master_uri)
        try:
            yield node
        finally:
            node.close()

    @contextlib.contextmanager
    def in_group(self, group: str) -> Iterator[None]:
        """Start processes in a namespace for a while."""
        self.environment["ROS_NAMESPACE"] = group
        try:
            yield
        finally:
            del self.environment["ROS_NAMESPACE"]

    def start(
        self,
        command: List[str],
        environment: Optional[Dict[str, str]] = None,
        talk: bool = False,
    ) -> "subprocess.Popen[bytes]":
        """Start a process; its output goes to a log in the directory.

        :param environment: in place of the session's own
        :param talk: give it pipes for standard input and output
        """
        self._numbers += 1
        log = self.directory / ("%03d-%s.log" % (self._numbers, pathlib.Path(command[0]).name))
        with log.open("wb") as output:
            process = subprocess.Popen(
                command,
                env=self.environment if environment is None else environment,
                stdin=subprocess.PIPE if talk else subprocess.DEVNULL,
                stdout=subprocess.PIPE if talk else output,
                stderr=output,
                cwd=str(self.directory),
                start_new_session=True,
            )
        self._running.append(process)
        return process

    def stop(self, process: "subprocess.Popen[bytes]", patience: float = PATIENCE) -> float:
        """End a process as Ctrl-C would.

        :param patience: how long it may take before it is killed, s
        :returns: how long it took, s
        """
        began = time.monotonic()
        for number in (signal.SIGINT, signal.SIGKILL):
            if process.poll() is not None:
                break
            os.killpg(process.pid, number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(patience)
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()
        if process in self._running:
            self._running.remove(process)
        return time.monotonic() - began

    @contextlib.contextmanager
    def running(self, *commands: List[str]) -> Iterator[List[int]]:
        """Run processes for a while; the last one started is the first to end.

        :returns: their numbers
        """
        processes: List["subprocess.Popen[bytes]"] = []
        try:
            for command in commands:
                processes.append(self.start(command))
            yield [process.pid for process in processes]
        finally:
            for process in reversed(processes):
                self.stop(process)


def cpu_time(pids: Iterable[int]) -> float:
    """Return the processor time that processes have used so far, s."""
    nanoseconds = 0
    for pid in pids:
        for thread in pathlib.Path("/proc/%d/task" % pid).glob("*/schedstat"):
            with contextlib.suppress(OSError):
                nanoseconds += int(thread.read_text().split()[0])
    return 1e-9 * nanoseconds


def cpu_share(pids: List[int], seconds: float) -> float:
    """Watch for a while how much of one core processes use, %."""
    began, used = time.monotonic(), cpu_time(pids)
    time.sleep(seconds)
    return 100.0 * (cpu_time(pids) - used) / (time.monotonic() - began)


def resident_memory(pids: Iterable[int]) -> float:
    """Return the resident set of processes together, MB."""
    kilobytes = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            for line in pathlib.Path("/proc/%d/status" % pid).read_text().splitlines():
                if line.startswith("VmRSS:"):
                    kilobytes += int(line.split()[1])
    return kilobytes / 1024.0


def descendants(pid: int) -> List[int]:
    """Return the numbers of all processes below one."""
    parents: Dict[int, int] = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            # The name in parentheses may hold anything; the parent is the second field after it.
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    found: List[int] = []
    wanted = [pid]
    while wanted:
        children = [child for child, parent in parents.items() if parent in wanted]
        found += children
        wanted = children
    return found
