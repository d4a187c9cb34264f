"""Press Ctrl-C at random moments of a node's life and see how it ends."""

import os
import random
import re
import signal
import subprocess
import tempfile
import time
from typing import Callable, List, NamedTuple, Sequence

from helpers.machine_lag import processor_waits
from roslib.packages import find_node

#: Longest moment after the start, s: by then a node runs, also on a busy machine mostly.
_LATEST = 1.0
#: A node that takes this long hangs [s].
_PATIENCE = 30.0
_OUR_LINES = re.compile(r'entry_point\.py", line \d+, in main')
#: Makes Python print a line for each imported module, and a traceback if it hangs.
_TOLD = {"PYTHONPROFILEIMPORTTIME": "1", "PYTHONFAULTHANDLER": "1"}
_IMPORT = re.compile(r"^import time:.*\| *(\S+)$", re.MULTILINE)
_ENTRY_POINT = "nodekit.entry_point"
#: Imported only when interrupts can be handled; it takes most of the startup.
_ROS = {"genpy", "rosgraph", "roslib", "rospy", "yaml"}


class End(NamedTuple):
    """End of a node.

    :param program: the program
    :param moment: time of the interrupt, after its start or its first line [s]
    :param seconds: from the interrupt to its end, without its waits for a processor [s]
    :param status: exit status
    :param from_our_lines: whether the time counts from the first line that can handle it
    :param errors: its stderr output
    :param survivors: ids of processes of its session that still run after its end
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
        """Whether Python had not reached the first line that can handle an interrupt.

        It is then killed by the signal, or prints a traceback, and has registered nothing.
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
    """Start a node and interrupt it, several times.

    Every third is interrupted at a time after its start, which may be too early for the node to
    handle it; the others at a time after it can.

    :param programs: executables of basic_comms, in turn
    :param count: number of rounds
    :param seed: of the random times
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

        def told() -> str:  # without moving the file position of the process
            return os.pread(errors.fileno(), os.fstat(errors.fileno()).st_size, 0).decode()

        try:
            if from_our_lines:
                _wait_for_our_lines(told)
            time.sleep(moment)
            interrupted_at, waited = time.monotonic(), _processor_wait(process.pid)
            process.send_signal(signal.SIGINT)
            if not _has_ended(process.pid, _PATIENCE):
                process.send_signal(signal.SIGABRT)
                process.wait()
                hung = told().rpartition("import time:")[2]
                raise AssertionError(f"{program} hangs, interrupted after {moment} s: {hung}")
            waited = _processor_wait(process.pid) - waited
            seconds = time.monotonic() - interrupted_at - waited
        finally:
            process.kill()
            process.wait()
        survivors = _session(process.pid)
        return End(program, moment, from_our_lines, seconds, process.returncode, told(), survivors)


def _has_ended(pid: int, patience: float) -> bool:
    """Wait for the end of a child process, which remains a zombie; return False on timeout."""
    deadline = time.monotonic() + patience
    while os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > deadline:
            return False
        time.sleep(0.005)
    return True


def _processor_wait(pid: int) -> float:
    """Return how long the main thread of a process, or of a zombie, has waited [s]."""
    return processor_waits(pid).get(str(pid), 0.0)


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
