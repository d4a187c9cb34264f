"""Processes for tests (Python program, ROS master), and a client of the parameter server."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from typing import IO, Any, Dict, Iterator, List, Optional, Sequence
from xmlrpc.client import ServerProxy

import rosgraph

from nodekit import master_process
from nodekit.testing.waiting import TIMEOUT_S, wait_until


def free_ports(count: int) -> List[int]:
    """Return different free TCP ports of localhost.

    :param count: number of ports
    """
    return master_process.free_ports(count)


def free_port() -> int:
    """Return a free TCP port of localhost."""
    return master_process.free_ports(1)[0]


class Process:
    """Process of a Python program, whose output lines are recorded.

    :param script: path of the program
    :param arguments: arguments of the command line
    :param environment: variables to set on top of the test's own
    """

    def __init__(
        self,
        script: str,
        arguments: Sequence[str] = (),
        environment: Optional[Dict[str, str]] = None,
    ) -> None:
        self.lines: List[str] = []
        self.error_lines: List[str] = []
        self.popen = subprocess.Popen(
            [sys.executable, script, *arguments],
            env={**os.environ, **(environment or {})},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            bufsize=1,
        )
        self._readers = [
            threading.Thread(target=self._read, args=parts, daemon=True)
            for parts in (
                (self.popen.stdout, self.lines),
                (self.popen.stderr, self.error_lines),
            )
        ]
        for reader in self._readers:
            reader.start()

    @staticmethod
    def _read(pipe: IO[str], into: List[str]) -> None:
        for line in pipe:
            into.append(line.rstrip("\n"))

    def logged(self, *words: str) -> List[str]:
        """Return the log's lines that contain all these words."""
        lines = [line for line in self.lines if not line.startswith("{")] + self.error_lines
        return [line for line in lines if all(word in line for word in words)]

    def wait_for_log(self, *words: str) -> None:
        """Wait for a line that contains all these words."""
        wait_until(lambda: self.logged(*words), lambda: f"{words} in {self.logged()}")

    def interrupt(self) -> int:
        """Send SIGINT as Ctrl-C does; return the exit status."""
        self.popen.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self) -> int:
        """Wait for the end; return the exit status."""
        status = self.popen.wait(TIMEOUT_S)
        for reader in self._readers:
            reader.join(TIMEOUT_S)
        return status

    def end(self) -> None:
        """Kill the process if it is running."""
        self.popen.kill()
        self.wait()


class Master(master_process.MasterProcess):
    """Master that can be killed and started again; a restart loses its parameters.

    :param start_new_session: whether it does not receive Ctrl-C of the terminal
    """

    def send_signal(self, number: int) -> None:
        """Send a signal; after SIGSTOP, wait until the master is stopped."""
        self.process.send_signal(number)
        if number == signal.SIGSTOP:
            wait_until(lambda: is_stopped(self.process.pid), lambda: "the master is still running")


def is_stopped(pid: int) -> bool:
    """Return whether all threads of a process are stopped by a signal.

    :param pid: process id
    """
    states = []
    for thread in os.listdir(f"/proc/{pid}/task"):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # just ended
            with open(f"/proc/{pid}/task/{thread}/stat") as stat:
                states.append(stat.read().rpartition(")")[2].split()[0])
    return set(states) == {"T"}


@contextlib.contextmanager
def hanging(pid: int) -> Iterator[None]:
    """Stop a process for a while; it is stopped on entry, however busy the machine is.

    :param pid: process id
    """
    os.kill(pid, signal.SIGSTOP)
    try:
        # The other threads run until the one that handles the signal is scheduled.
        wait_until(lambda: is_stopped(pid), lambda: f"process {pid} is still running")
        yield
    finally:
        with contextlib.suppress(ProcessLookupError):  # killed meanwhile
            os.kill(pid, signal.SIGCONT)


class Server:
    """Client of the parameter server, independent of the tested node.

    :param uri: URI of the master; the test's own by default
    """

    def __init__(self, uri: Optional[str] = None) -> None:
        self.uri = uri if uri is not None else rosgraph.get_master_uri()
        self._local = threading.local()

    @property
    def master(self) -> Any:
        """The master's XML-RPC interface, with a connection per thread."""
        if not hasattr(self._local, "proxy"):
            self._local.proxy = ServerProxy(self.uri)
        return self._local.proxy

    def get(self, key: str) -> Any:
        """Return a value or a namespace, None if it is not set."""
        code, _, value = self.master.getParam("/test", key)
        return value if code == 1 else None

    def set(self, key: str, value: Any) -> None:
        """Set a value or replace a namespace."""
        self.master.setParam("/test", key, value)

    def delete(self, key: str) -> None:
        """Delete a value or a namespace."""
        self.master.deleteParam("/test", key)

    def knows(self, node: str) -> bool:
        """Return whether a node has any registration, including parameters."""
        return bool(self.master.lookupNode("/test", node)[0] == 1)

    def services(self) -> List[str]:
        """Return the names of all services."""
        return [name for name, _ in self.master.getSystemState("/test")[2][2]]

    def wait_for(self, key: str, value: Any) -> None:
        """Wait until the server holds a value."""
        wait_until(
            lambda: same(self.get(key), value),
            lambda: f"{key} is {self.get(key)!r}, not {value!r}",
        )


def same(one: Any, other: Any) -> bool:
    """Return whether values look the same to users: 1, 1.0 and True differ."""
    return repr(one) == repr(other)
