"""The processes of a controller: whether they have anything to do, and how much they do.

Linux marks a thread as ready to run in the moment in which a message reaches it, before the sender
is told that it was sent. So when all threads wait, all that was sent has been dealt with, however
busy the machine is: a thread that has to wait for a processor is ready to run. Where the machine is
so busy that Linux leaves the delivery to its threads ksoftirqd, those are ready to run.
"""

import contextlib
import os
import signal
import time
from typing import Dict, Iterator, List, Set

#: Variable of the environment by which the processes of a controller are known.
MARK = "PID_CONTROL_JUDGE"
_TICKS = float(os.sysconf("SC_CLK_TCK"))
#: How often new processes and threads are looked for, s.
_LOOK_EVERY_S = 0.2
#: Pause between two looks, s.
_PAUSE_S = 5e-5


class ProcessWatch:
    """All processes with a mark in their environment, and the threads of this one but the caller's.

    What this process's threads have to do is part of the same business: they hear the controller.

    :param mark: value of :data:`MARK` that the controller was started with
    """

    def __init__(self, mark: str) -> None:
        self._mark = f"{MARK}={mark}".encode()
        self._states: Dict[str, int] = {}
        #: How many threads each process had when they were looked for.
        self._counts: Dict[int, int] = {}
        self._delivering = _delivering_threads()
        self._pids: Set[int] = set()
        self._searched_at = -1.0
        #: Processor time of processes that have ended, s.
        self._spent: Dict[int, float] = {}

    def pids(self) -> List[int]:
        """Return the processes that there are now."""
        found = []
        for name in os.listdir("/proc"):
            if name.isdigit() and int(name) != os.getpid():
                with contextlib.suppress(OSError):  # it has just ended, or is somebody else's
                    with open(f"/proc/{name}/environ", "rb") as environment:
                        if self._mark in environment.read().split(b"\0"):
                            found.append(int(name))
        return found

    def busy(self) -> float:
        """Return the processor time that was used so far, s."""
        self._pids |= set(self.pids())
        for pid in self._pids:
            with contextlib.suppress(OSError, IndexError):
                with open(f"/proc/{pid}/stat") as stat:
                    fields = stat.read().rpartition(")")[2].split()
                self._spent[pid] = (int(fields[11]) + int(fields[12])) / _TICKS
        return sum(self._spent.values())

    def is_idle(self) -> bool:
        """Tell whether all threads wait for something."""
        now = time.monotonic()
        if now - self._searched_at > _LOOK_EVERY_S or self._has_other_threads():
            self._search()
            self._searched_at = now
        # Twice: a thread may have woken one that was looked at before, and wait since.
        return self._all_wait() and self._all_wait()

    def wait_idle(self, longest: float) -> bool:
        """Wait until all threads wait for something.

        :param longest: how long at most, s
        :returns: whether that came true
        """
        deadline = time.monotonic() + longest
        while not self.is_idle():
            if time.monotonic() > deadline:
                return False
            time.sleep(_PAUSE_S)
        return True

    def kill(self, patience: float) -> None:
        """End all processes, at once: nothing of what they would still do is judged.

        :param patience: how long that may take, s
        """
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline:
            pids = self.pids()
            if not pids:
                break
            for pid in pids:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            time.sleep(0.002)
        self.close()

    def close(self) -> None:
        """Forget all threads."""
        for descriptor in self._states.values():
            os.close(descriptor)
        self._states.clear()

    def _all_wait(self) -> bool:
        for path, descriptor in list(self._states.items()):
            try:
                # "pid (name) state", and a name of up to 15 characters may hold anything.
                state = os.pread(descriptor, 64, 0).rpartition(b")")[2][1:2]
            except OSError:  # it has ended
                os.close(self._states.pop(path))
                continue
            if state in (b"R", b"D"):
                return False
        return True

    def _has_other_threads(self) -> bool:
        """Tell whether a process has got another number of threads; it takes a few microseconds."""
        return any(_count_of_threads(pid) != count for pid, count in self._counts.items())

    def _search(self) -> None:
        own = os.path.basename(os.path.realpath("/proc/thread-self"))
        self._pids = set(self.pids())
        watched = [os.getpid(), *self._pids]
        self._counts = {pid: _count_of_threads(pid) for pid in watched}
        for path in [*self._threads(watched), *self._delivering]:
            if path not in self._states and not path.endswith(f"/{own}/stat"):
                with contextlib.suppress(OSError):
                    self._states[path] = os.open(path, os.O_RDONLY | os.O_CLOEXEC)

    @staticmethod
    def _threads(pids: List[int]) -> Iterator[str]:
        for pid in pids:
            with contextlib.suppress(OSError):
                for thread in os.listdir(f"/proc/{pid}/task"):
                    yield f"/proc/{pid}/task/{thread}/stat"


def _count_of_threads(pid: int) -> int:
    """Return how many threads a process has, 0 where it has ended."""
    try:
        return os.stat(f"/proc/{pid}/task").st_nlink - 2
    except OSError:
        return 0


def _delivering_threads() -> List[str]:
    """Return where the states are of the kernel's threads that deliver what is sent."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit():
            with contextlib.suppress(OSError):
                with open(f"/proc/{name}/comm") as comm:
                    if comm.read().startswith("ksoftirqd/"):
                        found.append(f"/proc/{name}/stat")
    return found
