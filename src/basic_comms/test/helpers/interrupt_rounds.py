"""Press Ctrl-C at random moments of a node's life and see how it ends."""

import os
import random
import re
import signal
import subprocess
import time
from typing import List, NamedTuple, Sequence

from roslib.packages import find_node

#: Longest moment after the start, s: by then a node runs, also on a busy machine mostly.
_LATEST = 1.0
#: No node takes so long, s; where one does, it hangs.
_PATIENCE = 30.0
_OUR_LINES = re.compile(r'entry_point\.py", line \d+, in main')


class End(NamedTuple):
    """How a node ended.

    :param program: what was run
    :param moment: when it was interrupted, after its start, s
    :param seconds: from then to its end, s
    :param status: exit status
    :param errors: what it wrote to stderr
    :param survivors: ids of processes of its session that are there after its end
    """

    program: str
    moment: float
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
    def clean(self) -> bool:
        """Whether it ended as a node should."""
        return self.status == 0 and "Traceback" not in self.errors and not self.survivors


def interrupt_rounds(programs: Sequence[str], count: int, seed: int) -> List[End]:
    """Start a node and interrupt it, a number of times.

    :param programs: executables of basic_comms, which take turns
    :param count: how many rounds
    :param seed: of the random moments
    """
    moments = random.Random(seed)
    return [
        _interrupt(programs[number % len(programs)], moments.uniform(0.0, _LATEST))
        for number in range(count)
    ]


def _interrupt(program: str, moment: float) -> End:
    process = subprocess.Popen(
        [find_node("basic_comms", program)[0]],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        start_new_session=True,
    )
    try:
        time.sleep(moment)
        interrupted_at = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=_PATIENCE)
        seconds = time.monotonic() - interrupted_at
    finally:
        process.kill()
        process.wait()
    return End(program, moment, seconds, process.returncode, errors, _session(process.pid))


def _session(leader: int) -> List[int]:
    """Return the processes of a session, zombies too."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/stat" % pid) as stat:
                session = int(stat.read().rpartition(")")[2].split()[3])
        except OSError:
            continue  # it has just ended
        if session == leader:
            found.append(int(pid))
    return found
