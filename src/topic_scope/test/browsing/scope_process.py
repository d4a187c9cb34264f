"""Scope in a separate process, which a test can stop and restart."""

import atexit
import functools
import os
import subprocess
from pathlib import Path
from typing import ClassVar, Type
from urllib.request import urlopen

import roslib.packages
from browsing.waiting import wait_until

from nodekit.testing.processes import free_port


class ScopeProcess:
    """Scope at its own port.

    :param arguments: its arguments, except the port
    :param variables: additional environment variables
    """

    program: ClassVar[str] = roslib.packages.find_node("topic_scope", "scope.py")[0]

    def __init__(self, *arguments: str, **variables: str) -> None:
        port = str(free_port())
        self._environment = {**os.environ, **variables}
        self._command = [self.program]
        self._command += ["--port", port, *arguments]
        self.url = "http://localhost:" + port
        self.start()

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def start(self) -> None:
        """Start the scope; the page waits for it."""
        self._process = subprocess.Popen(self._command, env=self._environment)

    def wait_until_served(self) -> None:
        """Wait until a page can be loaded."""

        def answers() -> bool:
            try:
                with urlopen(self.url) as answer:
                    return bool(answer.status == 200)
            except OSError:
                return False

        wait_until(answers, lambda: f"no answer at {self.url}")

    def stop(self) -> int:
        """Stop the scope, and return its exit status."""
        self._process.terminate()
        return self._process.wait(30.0)


class SlowScopeProcess(ScopeProcess):
    """Scope that sends ten frames per second."""

    program = str(Path(__file__).with_name("slow_scope.py"))


@functools.lru_cache(maxsize=None)
def shared_scope(*arguments: str, kind: Type[ScopeProcess] = ScopeProcess) -> ScopeProcess:
    """Return the scope that all tests of a process share; it may still be starting.

    :param arguments: its arguments, except the port
    :param kind: its class
    """
    scope = kind(*arguments)
    atexit.register(scope.stop)
    return scope
