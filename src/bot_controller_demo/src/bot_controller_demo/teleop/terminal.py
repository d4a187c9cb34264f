"""Terminal in raw mode, which delivers each key immediately and is restored at the end."""

import atexit
import os
import select
import subprocess
import termios
from typing import Any, List

#: Longest result of one read [bytes].
_MOST = 4096
#: Indices in the result of termios.tcgetattr.
_IFLAG, _LFLAG, _CC = 0, 3, 6
#: Shell command that waits for the end of this process, in any way, and restores the terminal.
_GUARD = 'cat; stty "$0" <&1'


class KeyTerminal:
    """Terminal without echo and line buffering.

    Ctrl-C works. Keys that would suspend or kill the process do not: the terminal would remain in
    raw mode, and the robot would keep driving. The terminal is restored by :meth:`close`, and at
    any other end of the process: after SIGKILL no handler runs, so a second process waits for it.

    :param descriptor: an open terminal
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._before: List[Any] = termios.tcgetattr(descriptor)
        saved = subprocess.check_output(["stty", "-g"], stdin=descriptor).strip()
        # In its own session, so that it does not receive the keys' signals.
        self._guard = subprocess.Popen(
            ["sh", "-c", _GUARD, saved],
            stdin=subprocess.PIPE,
            stdout=descriptor,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        atexit.register(self.close)
        mode: List[Any] = termios.tcgetattr(descriptor)
        mode[_IFLAG] &= ~termios.IXON
        mode[_LFLAG] &= ~(termios.ICANON | termios.ECHO | termios.IEXTEN)
        disabled = bytes([os.fpathconf(descriptor, "PC_VDISABLE") & 0xFF])
        for character in (termios.VQUIT, termios.VSUSP):
            mode[_CC][character] = disabled
        mode[_CC][termios.VMIN], mode[_CC][termios.VTIME] = 1, 0
        termios.tcsetattr(descriptor, termios.TCSANOW, mode)

    def read(self, timeout: float) -> str:
        """Return typed characters; empty after the timeout.

        :param timeout: longest wait [s]
        :raises EOFError: if the terminal was closed
        """
        if not select.select([self._descriptor], [], [], timeout)[0]:
            return ""
        try:
            typed = os.read(self._descriptor, _MOST)
        except OSError:
            typed = b""
        if not typed:
            raise EOFError("the terminal is gone")
        return typed.decode("utf-8", "replace")

    def close(self) -> None:
        """Restore the terminal; no effect if already restored or closed."""
        atexit.unregister(self.close)
        before, self._before = self._before, []
        if before:
            self._guard.kill()
            self._guard.communicate()
            try:
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, before)
            except termios.error:
                pass
