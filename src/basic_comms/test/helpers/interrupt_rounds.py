"""Press Ctrl-C at random moments of a node's life and see how it ends."""

import os
import random
import re
import signal
import subprocess
import tempfile
import time
from typing import Callable, List, NamedTuple, Sequence

from roslib.packages import find_node

#: Longest moment after the start, s: by then a node runs, also on a busy machine mostly.
_LATEST = 1.0
#: No node takes so long, s; where one does, it hangs.
_PATIENCE = 30.0
_OUR_LINES = re.compile(r'entry_point\.py", line \d+, in main')
#: Has Python write a line to stderr for each module that it has imported, and where it hangs.
_TOLD = {"PYTHONPROFILEIMPORTTIME": "1", "PYTHONFAULTHANDLER": "1"}
_IMPORT = re.compile(r"^import time:.*\| *(\S+)$", re.MULTILINE)
_ENTRY_POINT = "nodekit.entry_point"
#: What a node imports only once it can handle an interrupt; it takes most of its start.
_ROS = {"genpy", "rosgraph", "roslib", "rospy", "yaml"}


class End(NamedTuple):
    """End of a node.

    :param program: what was run
    :param moment: when it was interrupted, after its start or its first line, s
    :param seconds: from then to its end, s
    :param status: exit status
    :param from_our_lines: whether the moment counts from the first line that can handle it
    :param errors: what it wrote to stderr
    :param survivors: ids of processes of its session that are there after its end
    """

    program: str
    moment: float
    from_our_lines: bool
    seconds: float
    status: int
    errors: str
    survivors: List[int]

    @property
    def early(self) -> bool:
        """Whether Python was still on its way to the first line that can handle an interrupt.

        It then dies of the signal, or with a traceback of its own, and has told the master nothing.
        """
        by_python = "KeyboardInterrupt" in self.errors and not _OUR_LINES.search(self.errors)
        return self.status == -signal.SIGINT or (self.status != 0 and by_python)

    @property
    def imported_too_soon(self) -> List[str]:
        """Modules of ROS imported before an interrupt can be handled."""
        modules = _IMPORT.findall(self.errors)
        if _ENTRY_POINT in modules:
            modules = modules[: modules.index(_ENTRY_POINT)]
        return [module for module in modules if module.partition(".")[0] in _ROS]

    @property
    def clean(self) -> bool:
        """Whether it ended as a node should."""
        return self.status == 0 and "Traceback" not in self.errors and not self.survivors


def interrupt_rounds(programs: Sequence[str], count: int, seed: int) -> List[End]:
    """Start a node and interrupt it, a number of times.

    Every third is interrupted at a moment that counts from its start, which may be too early for
    the node to handle it; the others at one that counts from when it can.

    :param programs: executables of basic_comms, which take turns
    :param count: how many rounds
    :param seed: of the random moments
    """
    moments = random.Random(seed)
    return [
        _interrupt(programs[number % len(programs)], moments.uniform(0.0, _LATEST), number % 3 > 0)
        for number in range(count)
    ]


def _interrupt(program: str, moment: float, from_our_lines: bool) -> End:
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [find_node("basic_comms", program)[0]],
            env={**os.environ, **_TOLD},
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,
        )

        def told() -> str:  # without moving the place where the process writes
            return os.pread(errors.fileno(), os.fstat(errors.fileno()).st_size, 0).decode()

        try:
            if from_our_lines:
                _wait_for_our_lines(told)
            time.sleep(moment)
            interrupted_at = time.monotonic()
            process.send_signal(signal.SIGINT)
            try:
                process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGABRT)
                process.wait()
                hung = told().rpartition("import time:")[2]
                raise AssertionError(
                    f"{program} hangs, interrupted after {moment} s: {hung}"
                ) from None
            seconds = time.monotonic() - interrupted_at
        finally:
            process.kill()
            process.wait()
        survivors = _session(process.pid)
        return End(program, moment, from_our_lines, seconds, process.returncode, told(), survivors)


def _wait_for_our_lines(told: Callable[[], str]) -> None:
    """Wait until a program is within the first line that can handle an interrupt."""
    deadline = time.monotonic() + _PATIENCE
    # The next module of all is imported by that very line.
    while _ENTRY_POINT not in _IMPORT.findall(told())[:-1]:
        if time.monotonic() > deadline:
            raise AssertionError(f"it has not come to {_ENTRY_POINT}: {told()}")
        time.sleep(0.001)


def _session(leader: int) -> List[int]:
    """Return the processes of a session, zombies too."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat") as stat:
                session = int(stat.read().rpartition(")")[2].split()[3])
        except OSError:
            continue  # it has just ended
        if session == leader:
            found.append(int(pid))
    return found
