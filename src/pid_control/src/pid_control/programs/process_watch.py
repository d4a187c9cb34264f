"""Watch of a controller's processes: whether they are idle, and their processor time.

Linux marks a thread as ready to run when a message reaches it, before the sender's call returns. So
when all threads wait, all messages have been processed, however busy the machine is: a thread that
waits for a processor is ready to run. If the machine is so busy that Linux delegates the delivery
to its threads ksoftirqd, these are ready to run.
"""

import contextlib
import ctypes
import os
import signal
import time
from typing import Dict, Iterator, List, Sequence, Set

#: Number of Linux's prctl that makes this process the parent of orphans among its descendants.
_PR_SET_CHILD_SUBREAPER = 36
#: Interval of the searches for new processes and threads [s].
_SEARCH_EVERY_S = 0.2
#: Interval of the checks while waiting [s].
_PAUSE_S = 5e-5


def adopt_orphans() -> None:
    """Become the parent of descendants whose own parent ends, so that they can be found."""
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def own_children() -> Set[int]:
    """Return the child processes of this process."""
    return {pid for pid, parent in _parents().items() if parent == os.getpid()}


class ProcessWatch:
    """Watch of a controller's processes, its companions, and this process's threads.

    The controller's processes are the descendants of this process that are not older than the
    controller, whatever their session and environment. This process's threads, except the caller's,
    count because they receive the controller's messages. A request to a companion, such as the
    master, lets the controller wait while the companion computes.

    :param pid: the controller's first process
    :param older: child processes of this process that are not the controller's
    :param companions: processes that the controller waits for
    """

    def __init__(self, pid: int, older: Set[int], companions: Sequence[int] = ()) -> None:
        self._first, self._older, self._companions = pid, older, companions
        self._states: Dict[str, int] = {}
        #: Number of threads of each process at the latest search.
        self._counts: Dict[int, int] = {}
        self._delivering = _delivering_threads()
        self._pids: Set[int] = set()
        self._searched_at = -1.0
        #: Processor time by process, also of ended ones [s].
        self._spent: Dict[int, float] = {}
        #: The same at the previous call of :meth:`has_run`.
        self._run_before: Dict[int, float] = {}

    def pids(self) -> List[int]:
        """Return the running processes of the controller."""
        parents = _parents()
        found = [pid for pid, parent in parents.items() if parent == os.getpid()]
        found = [pid for pid in found if pid not in self._older]
        for pid in found:  # grows meanwhile
            found += [child for child, parent in parents.items() if parent == pid]
        return found

    def busy(self) -> float:
        """Return the processor time used so far [s]."""
        self._pids |= set(self.pids())
        for pid in self._pids:
            with contextlib.suppress(OSError):
                self._spent[pid] = processor_time(pid)
        return sum(self._spent.values())

    def has_run(self) -> bool:
        """Return whether a process found by the latest search has run since the previous call."""
        before, self._run_before = self._run_before, {}
        for pid in self._pids:
            with contextlib.suppress(OSError):
                self._run_before[pid] = processor_time(pid)
        return any(spent > before.get(pid, 0.0) for pid, spent in self._run_before.items())

    def has_library(self, name: str) -> bool:
        """Return True if a running process has loaded a library.

        :param name: start of the library's file name
        """
        for pid in self.pids():
            with contextlib.suppress(OSError):  # it has just ended
                with open(f"/proc/{pid}/maps") as maps:
                    if f"/{name}" in maps.read():
                        return True
        return False

    def is_idle(self) -> bool:
        """Return True if all threads are waiting."""
        now = time.monotonic()
        if now - self._searched_at > _SEARCH_EVERY_S or self._has_other_threads():
            self._search()
            self._searched_at = now
        # Twice: a thread may have woken a thread that was already checked, and wait since.
        return self._all_wait() and self._all_wait()

    def wait_idle(self, longest: float) -> bool:
        """Wait until all threads are waiting.

        :param longest: timeout [s]
        :returns: False on timeout
        """
        deadline = time.monotonic() + longest
        while not self.is_idle():
            if time.monotonic() > deadline:
                return False
            time.sleep(_PAUSE_S)
        return True

    def kill(self, patience: float) -> None:
        """Kill all processes together.

        :param patience: timeout [s]
        """
        deadline = time.monotonic() + patience
        killed: Set[int] = set()
        while time.monotonic() < deadline:
            pids = self.pids()
            if not pids:
                break
            for pid in pids:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            killed.update(pids)
            time.sleep(0.002)
        for pid in killed - {self._first}:  # the first process is its owner's to collect
            with contextlib.suppress(ChildProcessError):  # its own parent collects it
                os.waitpid(pid, os.WNOHANG)
        self.close()

    def close(self) -> None:
        """Close the files of all threads."""
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
        """Return True if a process's number of threads has changed, within microseconds."""
        return any(_count_of_threads(pid) != count for pid, count in self._counts.items())

    def _search(self) -> None:
        own = os.path.basename(os.path.realpath("/proc/thread-self"))
        self._pids = set(self.pids())
        watched = [os.getpid(), *self._companions, *self._pids]
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


def processor_time(pid: int) -> float:
    """Return the processor time of a process, to the nanosecond: see clock_getcpuclockid(3) [s].

    :param pid: the process
    :raises OSError: if it has ended
    """
    clock = ctypes.c_int()
    number = ctypes.CDLL(None).clock_getcpuclockid(pid, ctypes.byref(clock))
    if number:
        raise OSError(number, os.strerror(number))
    return time.clock_gettime(clock.value)


def _parents() -> Dict[int, int]:
    """Return the parent of each running process."""
    found = {}
    for name in os.listdir("/proc"):
        if name.isdigit():
            with contextlib.suppress(OSError):  # it has just ended
                with open(f"/proc/{name}/stat", "rb") as stat:
                    state, parent = stat.read().rpartition(b")")[2].split()[:2]
                if state not in (b"Z", b"X"):
                    found[int(name)] = int(parent)
    return found


def _count_of_threads(pid: int) -> int:
    """Return the number of threads of a process, 0 if it has ended."""
    try:
        return os.stat(f"/proc/{pid}/task").st_nlink - 2
    except OSError:
        return 0


def _delivering_threads() -> List[str]:
    """Return the paths of the states of the kernel's threads that deliver messages."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit():
            with contextlib.suppress(OSError):
                with open(f"/proc/{name}/comm") as comm:
                    if comm.read().startswith("ksoftirqd/"):
                        found.append(f"/proc/{name}/stat")
    return found
