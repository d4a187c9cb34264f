"""A terminal that hands over each key at once, and is given back as it was."""

import atexit
import os
import select
import subprocess
import termios
from typing import Any, List

#: Longest answer to one read, bytes.
_MOST = 4096
#: Places in what termios returns.
_IFLAG, _LFLAG, _CC = 0, 3, 6
#: A shell that waits for the end of the process, however it comes, and gives the terminal back.
_GUARD = 'cat; stty "$0" <&1'


class KeyTerminal:
    """A terminal without echo and without lines.

    Ctrl-C works. What would stop or kill the process on the way does not: it would leave the
    terminal as it is, and the robot driving. It is given back by :meth:`close`, and at any other
    end of the process: no handler would run at SIGKILL, so a second process waits for it.

    :param descriptor: an open terminal
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._before: List[Any] = termios.tcgetattr(descriptor)
        saved = subprocess.check_output(["stty", "-g"], stdin=descriptor).strip()
        # In a session of its own: the keys' signals are not for it.
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
        """Return what was typed, nothing where that takes too long.

        :param timeout: longest wait, s
        :raises EOFError: if the terminal is gone
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
        """Give the terminal back as it was; without effect a second time, or where it is gone."""
        atexit.unregister(self.close)
        before, self._before = self._before, []
        if before:
            self._guard.kill()
            self._guard.communicate()
            try:
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, before)
            except termios.error:
                pass
