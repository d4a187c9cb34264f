"""A command that a reader of the documentation types into a terminal."""

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Dict, Optional

from nodekit.testing.console import plain


class Job:
    """A command that runs in a shell and leaves its output in a file.

    :param command: what is typed
    :param folder: where
    :param environment: all its variables
    :param output: the file
    """

    def __init__(
        self, command: str, folder: Path, environment: Dict[str, str], output: Path
    ) -> None:
        self._output = output
        #: Index in the output up to which it has been compared.
        self.seen = 0
        with output.open("wb") as file:
            self._process = subprocess.Popen(
                ["bash", "-c", command],
                cwd=folder,
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
