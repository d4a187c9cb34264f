"""A ROS master of the benchmark's own, and the processes started on it."""

import contextlib
import os
import pathlib
import signal
import subprocess
import time
from typing import Dict, Iterator, List, Optional

from nodekit.testing.processes import free_port

from ..tiers.steps import end_leftovers
from .cost import descendants
from .observers import wait_until
from .peer_programs import SCRIPTS, WORKSPACE
from .tcpros import Node

#: how long a node works on after it has registered, s
SETTLED = 1.5
#: how long a process may take to end when asked to, s: a thousand groups have fifteen thousand
#: registrations to take back
PATIENCE_S = 10.0
#: longest time for what is left of those that were killed, s
CLEANUP_S = 60.0


def start_with_log(
    command: List[str], environment: Dict[str, str], log: pathlib.Path, talk: bool = False
) -> "subprocess.Popen[bytes]":
    """Start a process in a process group of its own, in the folder of its log.

    :param log: file for its output
    :param talk: give it pipes for standard input and output
    """
    with log.open("wb") as output:
        return subprocess.Popen(
            command,
            env=environment,
            stdin=subprocess.PIPE if talk else subprocess.DEVNULL,
            stdout=subprocess.PIPE if talk else output,
            stderr=output,
            cwd=str(log.parent),
            start_new_session=True,
        )


class Session:
    """A master on a free port; what was started on it ends with it.

    :param directory: for logs and files; a fresh one
    """

    def __init__(self, directory: pathlib.Path) -> None:
        self.directory = directory
        self._port = free_port()
        self.master_uri = f"http://localhost:{self._port}"
        self.environment = dict(
            os.environ,
            ROS_MASTER_URI=self.master_uri,
            ROS_HOSTNAME="localhost",
            ROS_HOME=str(directory / "ros"),
            ROS_LOG_DIR=str(directory / "ros" / "log"),
            ROS_PACKAGE_PATH=os.pathsep.join(
                [str(SCRIPTS / "course"), os.environ.get("ROS_PACKAGE_PATH", "")]
            ),
            PYTHONPATH=os.pathsep.join([str(WORKSPACE), os.environ.get("PYTHONPATH", "")]),
        )
        self.environment.pop("ROS_IP", None)
        # Or else each start compiles the workspace's own modules anew, and nobody else's.
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)
        self._running: List["subprocess.Popen[bytes]"] = []
        self._logs: Dict[int, pathlib.Path] = {}
        self._numbers = 0
        self._is_ending = False

    def __enter__(self) -> "Session":
        try:
            self.start(["roscore", "-p", str(self._port)])
            self._wait_for_master()
        except BaseException:
            self._end_all()
            raise
        return self

    def __exit__(self, *_error: object) -> None:
        self._end_all()

    def _wait_for_master(self) -> None:
        def answers() -> bool:
            with contextlib.suppress(OSError), self.node() as node:
                return "/rosout" in dict(node.master("getTopicTypes"))
            return False

        wait_until(answers, 30.0, "answer from the master")

    def _end_all(self) -> None:
        self._is_ending = True
        # The master last: the nodes take their leave of it.
        self.stop(*self._running[1:])
        self.stop(*self._running)
        end_leftovers(self.directory)

    @contextlib.contextmanager
    def node(self) -> Iterator[Node]:
        """Lend a node to measure with."""
        self._numbers += 1
        node = Node(f"/benchmark_{self._numbers}", self.master_uri)
        try:
            yield node
        finally:
            node.close()

    def wait_for(self, name: str) -> None:
        """Wait until a node has come up, and until it has then settled.

        :param name: its global name
        """

        def is_registered() -> bool:
            with contextlib.suppress(RuntimeError):
                return bool(node.master("lookupNode", name))
            time.sleep(0.02)
            return False

        with self.node() as node:
            wait_until(is_registered, 30.0, "registration of " + name)
        time.sleep(SETTLED)

    def in_group(self, group: str) -> Dict[str, str]:
        """Return the environment of processes in a namespace."""
        return dict(self.environment, ROS_NAMESPACE=group)

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
        log = self.directory / f"{self._numbers:03}-{pathlib.Path(command[0]).name}.log"
        variables = self.environment if environment is None else environment
        process = start_with_log(command, variables, log, talk)
        self._running.append(process)
        self._logs[process.pid] = log
        return process

    def log_of(self, process: "subprocess.Popen[bytes]") -> str:
        """Return what a process has written so far."""
        return self._logs[process.pid].read_text(errors="replace")

    def stop(self, *processes: "subprocess.Popen[bytes]") -> float:
        """End processes as Ctrl-C would, or the hard way those that take too long.

        What they have started ends with them.

        :returns: how long the last one took, s
        """
        began = time.monotonic()
        started = [pid for process in processes for pid in descendants(process.pid)]
        for number in (signal.SIGINT, signal.SIGKILL):
            remaining = [process for process in processes if process.poll() is None]
            for process in remaining:
                os.killpg(process.pid, number)
            give_up = time.monotonic() + PATIENCE_S
            for process in remaining:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(max(0.0, give_up - time.monotonic()))
        lasted = time.monotonic() - began
        killed = [process for process in processes if process.returncode == -signal.SIGKILL]
        for pid in started:
            with contextlib.suppress(ProcessLookupError):
                if self._is_of_session(pid):
                    os.kill(pid, signal.SIGKILL)
        if killed and not self._is_ending:
            self._clean_up()
        for process in processes:
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    pipe.close()
            if process in self._running:
                self._running.remove(process)
        return lasted

    def _clean_up(self) -> None:
        """Have the master forget those that were killed, who would be part of what comes next."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            subprocess.run(
                ["rosnode", "cleanup"],
                env=self.environment,
                input=b"y\n",
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                timeout=CLEANUP_S,
            )

    def _is_of_session(self, pid: int) -> bool:
        """Tell whether a process is still there, and no other that has got its number since."""
        with contextlib.suppress(OSError):
            environment = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
            return b"ROS_MASTER_URI=" + self.master_uri.encode() in environment
        return False

    @contextlib.contextmanager
    def running(
        self, *commands: List[str], environment: Optional[Dict[str, str]] = None
    ) -> Iterator[List[int]]:
        """Run processes for a while.

        :param environment: in place of the session's own
        :returns: their numbers
        """
        processes: List["subprocess.Popen[bytes]"] = []
        try:
            for command in commands:
                processes.append(self.start(command, environment))
            yield [process.pid for process in processes]
        finally:
            self.stop(*reversed(processes))
