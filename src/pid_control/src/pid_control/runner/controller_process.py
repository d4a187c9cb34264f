"""A controller's process: started unchanged, its words kept, and nothing of it left behind."""

import contextlib
import os
import signal
import subprocess
import threading
import uuid
from typing import Dict, Optional

from pid_control.runner.controller_command import ControllerCommand
from pid_control.runner.deferred_signals import deferred_signals
from pid_control.runner.process_watch import MARK, ProcessWatch

#: How much of its output is kept, and how much of it is too much for a controller, bytes.
_KEPT, _TOO_MUCH = 4000, 5_000_000
#: How long processes may take to end, s.
_PATIENCE_S = 2.0


class ControllerProcess:
    """A controller that runs.

    It has a process group of its own, so that Ctrl-C reaches the judge alone. To be made while
    interrupts are put off, until there is somebody who ends it.

    :param command: what to start
    :param environment: variables to set, besides those of the command
    :raises OSError: if it cannot be started
    """

    def __init__(self, command: ControllerCommand, environment: Dict[str, str]) -> None:
        mark = uuid.uuid4().hex
        self.watch = ProcessWatch(mark)
        self._tail = b""
        self._written = 0
        self._popen = subprocess.Popen(
            command.argv,
            env={**command.environment, **environment, MARK: mark},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def status(self) -> Optional[int]:
        """Its exit status; None while it runs."""
        return self._popen.poll()

    @property
    def writes_without_end(self) -> bool:
        """Whether it has written far more than a log."""
        return self._written > _TOO_MUCH

    def last_words(self) -> str:
        """Return the last line that it wrote, if any."""
        if self.status is not None:
            self._reader.join(_PATIENCE_S)  # or the line may be on its way
        lines = self._tail.decode(errors="replace").splitlines()
        spoken = [line.strip() for line in lines if line.strip()]
        return spoken[-1][:300] if spoken else ""

    def interrupt(self) -> None:
        """Press Ctrl-C, and give it the time to end."""
        with contextlib.suppress(ProcessLookupError, subprocess.TimeoutExpired):
            os.killpg(self._popen.pid, signal.SIGINT)
            self._popen.wait(_PATIENCE_S)

    def end(self) -> None:
        """End it, and all that it started; interrupts wait until that is done."""
        with deferred_signals():
            self._popen.kill()  # which the watch does not know for a moment while it is started
            self.watch.kill(_PATIENCE_S)
            self._popen.wait()
            self._reader.join(_PATIENCE_S)

    def _read(self) -> None:
        assert self._popen.stdout is not None
        with self._popen.stdout as pipe:
            while True:
                read = os.read(pipe.fileno(), 65536)
                if not read:
                    return
                self._written += len(read)
                self._tail = (self._tail + read)[-_KEPT:]
