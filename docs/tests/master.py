"""A master of a test's own."""

import os
import shutil
import signal
from typing import Any
from xmlrpc.client import ServerProxy

from pages import environment_of_reader
from warm_python import Program, WarmPython

from nodekit.testing.processes import free_port
from nodekit.testing.waiting import wait_until


class PrivateMaster:
    """A running master that answers.

    :param python: runs it
    """

    def __init__(self, python: WarmPython) -> None:
        program = shutil.which("rosmaster")
        assert program
        while True:
            port = free_port()
            self.uri = f"http://localhost:{port}/"
            argv = [program, "--core", "-p", str(port)]
            self._process = python.start(
                Program(argv, "/", environment_of_reader(), *[os.devnull] * 2)
            )
            answering = wait_until(self._pid, lambda: "no answer of the master")
            if answering == self._process.pid:
                break
            self.end()  # another process has taken the port

    def end(self) -> None:
        """End it at once."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()

    def _pid(self) -> int:
        try:
            with ServerProxy(self.uri) as proxy:
                answer: Any = proxy.getPid("/test")
                return int(answer[2])
        except OSError:
            return 0
