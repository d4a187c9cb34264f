"""A command that a reader of the documentation types into a terminal."""

import functools
import os
import re
import select
import shlex
import signal
import subprocess
import termios
import threading
import time
from pathlib import Path
from typing import Dict, List, Optional, Union

import rospkg
from roslib.packages import find_node
from console_blocks import plain
from warm_python import Program, WarmProcess, WarmPython, python_file


_rospack = rospkg.RosPack()


def expanded(command: str, folder: Path, environment: Dict[str, str]) -> List[str]:
    """Return the words of a simple command as bash passes them on.

    :returns: nothing where the command is more than a program and its arguments
    """
    lexer = shlex.shlex(command, posix=True, punctuation_chars=True)
    try:
        if any(set(word) <= set("();<>|&") for word in lexer if word):
            return []
    except ValueError:  # a quotation mark in a comment
        return []
    if "`" in command or re.match(r"\w+=", command):
        return []
    words = subprocess.run(
        ["bash", "-c", rf"printf '%s\0' {command}"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        check=True,
    ).stdout
    return words.decode().split("\0")[:-1]


def python_program(words: List[str], folder: Path, environment: Dict[str, str]) -> List[str]:
    """Return the Python file that a command runs, through rosrun or not, and its arguments.

    :param words: the command, see :func:`expanded`
    :returns: nothing where the command runs another program
    """
    if words[:1] == ["rosrun"]:
        path = _executable(*words[1:3]) if len(words) > 2 else None
        return python_file([path, *words[3:]], environment) if path else []
    if words and "/" in words[0]:
        words = [str(folder / words[0]), *words[1:]]
    return python_file(words, environment)


@functools.lru_cache(maxsize=None)
def _executable(package: str, name: str) -> Optional[str]:
    """Return the path of an executable, found as roslaunch finds it."""
    try:
        found = find_node(package, name, _rospack)
    except rospkg.ResourceNotFound:
        return None
    return str(found[0]) if found else None


class Terminal:
    """A terminal of which all that is written to it is kept in a file.

    :param output: the file
    """

    def __init__(self, output: Path) -> None:
        self._controller, self._other_end = os.openpty()
        #: Path of the device.
        self.name = os.ttyname(self._other_end)
        attributes = termios.tcgetattr(self._other_end)
        attributes[1] &= ~termios.OPOST  # what is written is passed on as it is
        termios.tcsetattr(self._other_end, termios.TCSANOW, attributes)
        os.set_blocking(self._controller, False)
        self._file = output.open("ab", 0)
        self._lock = threading.Lock()

    def follow(self) -> None:
        """Copy until the last program that has opened the terminal has ended."""
        os.close(self._other_end)
        threading.Thread(target=self._follow, daemon=True).start()

    def copy(self) -> bool:
        """Copy what has been written so far; return whether more may come."""
        with self._lock:
            while not self._file.closed:
                try:
                    self._file.write(os.read(self._controller, 65536))
                except BlockingIOError:
                    return True
                except OSError:  # no program has it open any longer
                    break
        return False

    def _follow(self) -> None:
        poll = select.poll()
        poll.register(self._controller, select.POLLIN)
        while self.copy():
            poll.poll()
        with self._lock:
            self._file.close()
            os.close(self._controller)


class Job:
    """A command that runs and leaves its output in a file.

    :param command: what is typed
    :param folder: where
    :param environment: all its variables
    :param output: the file
    :param goes_on: whether the output is watched while the command runs; it is a terminal then, as
        programs keep back what they write elsewhere
    :param python: runs the command if that is a Python program and nothing else; otherwise bash
        runs it
    """

    def __init__(
        self,
        command: str,
        folder: Path,
        environment: Dict[str, str],
        output: Path,
        goes_on: bool,
        python: Optional[WarmPython] = None,
    ) -> None:
        self._output = output
        #: Index in the output up to which it has been compared.
        self.seen = 0
        output.touch()
        self._read = (0, "")  # how much was there, and what
        self._terminal = Terminal(output) if goes_on else None
        place = self._terminal.name if self._terminal else str(output)
        words = expanded(command, folder, environment) if python else []
        argv = python_program(words, folder, environment)
        self._process: Union["subprocess.Popen[bytes]", WarmProcess]
        if python and argv:
            self._process = python.start(Program(argv, str(folder), environment, place, place))
        else:
            with open(os.open(place, os.O_WRONLY | os.O_APPEND | os.O_NOCTTY), "wb") as file:
                self._process = subprocess.Popen(
                    ["bash", "-c", command],
                    cwd=folder,
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=file,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
        if self._terminal:
            self._terminal.follow()

    @property
    def status(self) -> Optional[int]:
        """Exit status, None while it runs; all of its output is there then."""
        status = self._process.poll()
        if status is not None and self._terminal:
            self._terminal.copy()
        return status

    def output(self) -> str:
        """Return what it has printed so far."""
        size = self._output.stat().st_size
        if size != self._read[0]:
            self._read = size, plain(self._output.read_text(errors="replace"))
        return self._read[1]

    def ended_by(self, deadline: float) -> bool:
        """Wait for its end.

        :param deadline: on the monotonic clock, s
        :returns: whether it has ended
        """
        try:
            self._process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            return False
        return self.status is not None

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        os.killpg(self._process.pid, signal.SIGINT)

    def kill(self) -> None:
        """End it at once, if it runs."""
        if self.status is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
