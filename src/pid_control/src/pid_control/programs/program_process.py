"""Process of a student's program: its start and end, child processes, and last output."""

import contextlib
import os
import signal
import subprocess
import threading
from typing import Dict, Optional, Sequence

from pid_control.programs.program_command import ProgramCommand
from pid_control.programs.deferred_signals import deferred_signals
from pid_control.programs.process_watch import (
    ProcessWatch,
    adopt_orphans,
    own_children,
    processor_time,
)
from pid_control.programs.python_crash import crash_in

#: Kept tail of the output, and output that is too long for a controller [bytes].
_KEPT, _TOO_MUCH = 20_000, 5_000_000
#: Timeout for processes to end [s].
_PATIENCE_S = 2.0


class ProgramProcess:
    """Running program of a student, such as a controller.

    The process has its own process group, so that Ctrl-C reaches only the judge. Create the object
    with signals deferred until its owner can end it.

    :param command: command of the controller
    :param environment: environment variables in addition to those of the command
    :param companions: processes that the controller waits for, such as the master
    :raises OSError: if the process cannot be started
    """

    def __init__(
        self,
        command: ProgramCommand,
        environment: Dict[str, str],
        companions: Sequence[int] = (),
    ) -> None:
        adopt_orphans()
        older = own_children()
        self._argv = command.argv
        self._tail = b""
        self._written = 0
        self._popen = subprocess.Popen(
            command.argv,
            env={**command.environment, **environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self.watch = ProcessWatch(self._popen.pid, older, companions)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def status(self) -> Optional[int]:
        """The exit status; None while the process runs."""
        return self._popen.poll()

    @property
    def writes_without_end(self) -> bool:
        """True if the output is far longer than a log."""
        return self._written > _TOO_MUCH

    def processor_time(self) -> float:
        """Return the processor time of the process without its children [s]; 0 if it has ended."""
        try:
            return processor_time(self._popen.pid)
        except OSError:
            return 0.0

    def last_words(self) -> str:
        """Return the exception that ended the process, else the last line of its output, if any.

        An exception that is the last line, as of a callback, has its line of the program too.
        """
        has_ended = self.status is not None
        if has_ended:
            self._reader.join(_PATIENCE_S)  # the last line may still be in the pipe
        output = self._tail.decode(errors="replace")
        spoken = [line.strip() for line in output.splitlines() if line.strip()]
        last = spoken[-1] if spoken else ""
        crash = crash_in(output, self._argv)
        return (crash if crash and (has_ended or crash.startswith(last)) else last)[:300]

    def interrupt(self) -> None:
        """Send SIGINT, and wait for the process to end."""
        with contextlib.suppress(ProcessLookupError, subprocess.TimeoutExpired):
            os.killpg(self._popen.pid, signal.SIGINT)
            self._popen.wait(_PATIENCE_S)

    def end(self) -> None:
        """Kill the process and all of its child processes, with signals deferred."""
        with deferred_signals():
            self._popen.kill()
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
