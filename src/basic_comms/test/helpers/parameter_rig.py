"""What tests of live parameters are made of: processes, and a client of the parameter server."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import unittest
from typing import IO, Any, Dict, List, Optional, Sequence
from xmlrpc.client import ServerProxy

import rosgraph

from helpers.waiting import TIMEOUT, wait_until

HELPERS = os.path.dirname(os.path.abspath(__file__))


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
            [sys.executable, "-u", script, *arguments],
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
        wait_until(lambda: self.logged(*words), lambda: "%s in %s" % (words, self.logged()))

    def interrupt(self) -> int:
        """Press Ctrl-C; return the exit status."""
        self.popen.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self) -> int:
        """Wait for the end; return the exit status."""
        status = self.popen.wait(TIMEOUT)
        for reader in self._readers:
            reader.join(TIMEOUT)
        return status

    def end(self) -> None:
        """Kill it, if it has not ended yet."""
        self.popen.kill()
        self.wait()


class ParameterNode(Process):
    """A parameter_node.py.

    :param name: its global name
    :param environment: variables to set on top of the test's own
    """

    def __init__(self, name: str, environment: Optional[Dict[str, str]] = None) -> None:
        namespace, _, base = name.rpartition("/")
        self.name = name
        super().__init__(
            os.path.join(HELPERS, "parameter_node.py"),
            ["__name:=" + base],
            {"ROS_NAMESPACE": namespace or "/", **(environment or {})},
        )

    @property
    def reports(self) -> List[Dict[str, Any]]:
        """What it printed of its values, oldest first."""
        return [json.loads(line) for line in self.lines if line.startswith("{")]

    @property
    def values(self) -> Dict[str, Any]:
        """The values in force."""
        return dict(self.reports[-1]["values"])

    @property
    def changes(self) -> int:
        """How often its callback was called."""
        return int(self.reports[-1]["changes"])

    def wait_for(self, **values: Any) -> None:
        """Wait until these values are in force."""
        wait_until(
            lambda: self.reports and {**self.values, **values} == self.values,
            lambda: "%s in %s; log: %s" % (values, self.reports[-1:], self.logged()[-5:]),
        )

    def tell(self, **command: Any) -> None:
        """Have it obey a command, see parameter_node.py."""
        self.popen.stdin.write(json.dumps(command) + "\n")


class Spy(Process):
    """A parameter_spy.py.

    :param keys: what it is notified of
    """

    def __init__(self, *keys: str) -> None:
        super().__init__(os.path.join(HELPERS, "parameter_spy.py"), keys)
        wait_until(lambda: self.lines, lambda: "spy: %s" % self.error_lines)

    @property
    def updates(self) -> List[List[Any]]:
        """Key and value of each write, oldest first."""
        return [json.loads(line) for line in self.lines[1:]]


class Master:
    """A master that can be killed and started again; its parameters go with it."""

    def __init__(self) -> None:
        with socket.socket() as chooser:
            chooser.bind(("localhost", 0))
            self._port = chooser.getsockname()[1]
        self.uri = "http://localhost:%d/" % self._port
        self.start()

    def start(self) -> None:
        """Start it and wait until it answers."""
        self._popen = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(self._port)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        wait_until(self._answers, lambda: "no answer of the master")

    def kill(self) -> None:
        """End it at once."""
        self._popen.kill()
        self._popen.wait(TIMEOUT)

    def _answers(self) -> bool:
        try:
            with ServerProxy(self.uri) as proxy:
                return bool(proxy.getPid("/test")[0] == 1)
        except OSError:
            return False


class Server:
    """The parameter server as some other node sees it.

    :param uri: of the master; the test's own by default
    """

    def __init__(self, uri: Optional[str] = None) -> None:
        self.uri = uri if uri is not None else rosgraph.get_master_uri()
        self._local = threading.local()

    @property
    def master(self) -> ServerProxy:
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
            lambda: "%s is %r, not %r" % (key, self.get(key), value),
        )


def same(one: Any, other: Any) -> bool:
    """Compare values as users see them: 1, 1.0 and True are three."""
    return repr(one) == repr(other)


class ParameterCase(unittest.TestCase):
    """A test that starts processes and knows what must always hold of a node."""

    def launch_node(self, name: str, **environment: str) -> ParameterNode:
        """Start a node that is killed at the end of the test."""
        node = ParameterNode(name, environment)
        self.addCleanup(node.end)
        return node

    def start_node(self, name: str, **environment: str) -> ParameterNode:
        """Start a node as above and wait for its first values."""
        node = self.launch_node(name, **environment)
        wait_until(lambda: node.reports, lambda: "start of %s: %s" % (name, node.logged()))
        return node

    def assert_truth(self, node: ParameterNode, server: Server) -> None:
        """Wait until the server holds just what the node uses."""

        def told() -> Dict[str, Any]:
            held = server.get(node.name)
            return {k: v for k, v in held.items() if k in node.values} if held else {}

        wait_until(
            lambda: told() == node.values,
            lambda: "the server holds %s, in force is %s" % (told(), node.values),
        )
