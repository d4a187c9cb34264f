"""Processes that a test starts and ends, a master among them, and a client of the master."""

import contextlib
import errno
import os
import random
import signal
import socket
import subprocess
import sys
import threading
from typing import IO, Any, Dict, Iterator, List, Optional, Sequence
from xmlrpc.client import ServerProxy

import rosgraph

from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: Ports that Linux gives to nobody who does not name them (its ip_local_port_range begins behind):
#: one of another test's nodes could have any other before it is made use of. They begin behind
#: those of ROS itself: 11311, a master's, and 11411, where rosserial listens for boards.
_PORTS = range(12_000, 32_768)
#: Tests seed the module's own, all alike.
_random = random.SystemRandom()


def free_ports(count: int) -> List[int]:
    """Return different TCP ports of localhost that nothing listens on.

    :param count: how many
    """
    ports: List[int] = []
    with contextlib.ExitStack() as probes:
        while len(ports) < count:
            probe, port = probes.enter_context(socket.socket()), _random.choice(_PORTS)
            try:
                probe.bind(("localhost", port))
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    raise
            else:
                ports.append(port)
    return ports


def free_port() -> int:
    """Return a TCP port of localhost that nothing listens on."""
    return free_ports(1)[0]


class Process:
    """A Python program of which every line of output is kept.

    :param script: path of the program
    :param arguments: of the command line
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
        """Press Ctrl-C; return the exit status."""
        self.popen.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self) -> int:
        """Wait for the end; return the exit status."""
        status = self.popen.wait(TIMEOUT_S)
        for reader in self._readers:
            reader.join(TIMEOUT_S)
        return status

    def end(self) -> None:
        """Kill it, if it has not ended yet."""
        self.popen.kill()
        self.wait()


class Master:
    """A master that can be killed and started again; its parameters go with it.

    :param start_new_session: whether Ctrl-C in a terminal is kept from it
    """

    def __init__(self, start_new_session: bool = False) -> None:
        self._start_new_session = start_new_session
        self._take_port()
        while self._pid_there() != self._popen.pid:  # another process has taken the port, too
            self.kill()
            self._take_port()

    def _take_port(self) -> None:
        self._port = free_port()
        self.uri = f"http://localhost:{self._port}/"
        self.start()

    def start(self) -> None:
        """Start it and wait until it answers."""
        self._popen = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(self._port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=self._start_new_session,
        )
        try:
            wait_until(self._pid_there, lambda: "no answer of the master")
        except BaseException:
            self.kill()
            raise

    def kill(self) -> None:
        """End it at once."""
        self._popen.kill()
        self._popen.wait(TIMEOUT_S)

    def send_signal(self, number: int) -> None:
        """Send it a signal, as SIGSTOP to have it hang; that is waited for."""
        self._popen.send_signal(number)
        if number == signal.SIGSTOP:
            wait_until(lambda: is_stopped(self._popen.pid), lambda: "the master goes on")

    def _pid_there(self) -> Optional[int]:
        """Return the process id of the master that answers, None where none does."""
        try:
            with ServerProxy(self.uri) as proxy:
                answer: Any = proxy.getPid("/test")
                return int(answer[2])
        except OSError:
            return None


def is_stopped(pid: int) -> bool:
    """Tell whether all threads of a process have been stopped by a signal.

    :param pid: its process id
    """
    states = []
    for thread in os.listdir(f"/proc/{pid}/task"):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # it has just ended
            with open(f"/proc/{pid}/task/{thread}/stat") as stat:
                states.append(stat.read().rpartition(")")[2].split()[0])
    return set(states) == {"T"}


@contextlib.contextmanager
def hanging(pid: int) -> Iterator[None]:
    """Have a process hang for a while, which it does at once, however busy the machine is.

    :param pid: its process id
    """
    os.kill(pid, signal.SIGSTOP)
    try:
        # Until the thread that takes the signal has had its turn, the others go on.
        wait_until(lambda: is_stopped(pid), lambda: f"process {pid} goes on")
        yield
    finally:
        with contextlib.suppress(ProcessLookupError):  # it was killed meanwhile
            os.kill(pid, signal.SIGCONT)


class Server:
    """The parameter server as some other node sees it.

    :param uri: of the master; the test's own by default
    """

    def __init__(self, uri: Optional[str] = None) -> None:
        self.uri = uri if uri is not None else rosgraph.get_master_uri()
        self._local = threading.local()

    @property
    def master(self) -> Any:
        """The master's own interface; a connection for each thread."""
        if not hasattr(self._local, "proxy"):
            self._local.proxy = ServerProxy(self.uri)
        return self._local.proxy

    def get(self, key: str) -> Any:
        """Return a value or a namespace, None where nothing is set."""
        code, _, value = self.master.getParam("/test", key)
        return value if code == 1 else None

    def set(self, key: str, value: Any) -> None:
        """Set a value or replace a namespace."""
        self.master.setParam("/test", key, value)

    def delete(self, key: str) -> None:
        """Delete a value or a namespace."""
        self.master.deleteParam("/test", key)

    def knows(self, node: str) -> bool:
        """Tell whether anything is registered under the name of a node, parameters included."""
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
    """Compare values as users see them: 1, 1.0 and True are three."""
    return repr(one) == repr(other)
