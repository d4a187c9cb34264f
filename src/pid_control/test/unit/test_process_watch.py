"""Tests of the watch of a controller's processes."""

import os
import subprocess
import sys
import time
from typing import Iterator, List, Sequence, Set

import pytest

from nodekit.testing.waiting import wait_until
from pid_control.programs import process_watch
from pid_control.programs.process_watch import ProcessWatch, adopt_orphans, own_children

#: Starts a thread for each line that it reads, which computes until the next.
LATE_THREADS = """
import sys, threading
lines = []
def work(mine):
    while len(lines) == mine:
        pass
for line in sys.stdin:
    lines.append(line)
    if line == "work\\n":
        threading.Thread(target=work, args=(len(lines),), daemon=True).start()
    print("heard", flush=True)
"""


class Watched:
    """A process that a watch knows."""

    def __init__(self, command: List[str], companions: Sequence[int] = ()) -> None:
        adopt_orphans()
        older = own_children()
        self.popen = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )
        self.watch = ProcessWatch(self.popen.pid, older, companions)


@pytest.fixture
def computing() -> Iterator[Watched]:
    process = Watched([sys.executable, "-c", LATE_THREADS])
    yield process
    process.popen.kill()
    process.popen.communicate()
    process.watch.close()


def say(process: Watched, line: bytes) -> None:
    assert process.popen.stdin is not None and process.popen.stdout is not None
    process.popen.stdin.write(line)
    process.popen.stdin.flush()
    assert process.popen.stdout.readline() == b"heard\n"


def test_has_library_is_true_for_those_that_the_process_has_loaded(computing: Watched) -> None:
    say(computing, b"rest\n")
    assert computing.watch.has_library("libc.so")
    assert not computing.watch.has_library("libroscpp.so")


def test_is_idle_new_computing_thread_is_detected(computing: Watched) -> None:
    say(computing, b"rest\n")
    assert computing.watch.wait_idle(30.0)
    descriptors = len(os.listdir("/proc/self/fd"))
    say(computing, b"work\n")
    assert not computing.watch.is_idle()
    assert not computing.watch.wait_idle(0.2)
    say(computing, b"rest\n")
    assert computing.watch.wait_idle(30.0)

    def has_closed() -> bool:
        return computing.watch.is_idle() and len(os.listdir("/proc/self/fd")) <= descriptors

    wait_until(has_closed, lambda: "the file of the ended thread is open")


def test_is_idle_thread_that_is_woken_after_its_turn_is_detected(
    computing: Watched, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    read: Set[int] = set()

    def states(descriptor: int, *_: int) -> bytes:
        """Return that a thread waits, and that it is ready to run when it is read again."""
        state = b"R" if descriptor in read else b"S"
        read.add(descriptor)
        return b"1 (python) " + state

    monkeypatch.setattr("os.pread", states)
    assert not computing.watch.is_idle()


def test_busy_counts_processor_time(computing: Watched) -> None:
    say(computing, b"work\n")
    before = computing.watch.busy()
    wait_until(lambda: computing.watch.busy() > before + 0.1, lambda: "no processor time")


def test_processor_time_is_that_of_a_process_and_an_error_once_it_has_ended() -> None:
    before = time.process_time()
    assert before < process_watch.processor_time(os.getpid()) < time.process_time()
    ended = subprocess.Popen(["true"])
    ended.wait()
    with pytest.raises(ProcessLookupError):
        process_watch.processor_time(ended.pid)


def test_has_run_is_false_of_a_process_that_waits(computing: Watched) -> None:
    wait_until(computing.watch.is_idle, lambda: "it computes")
    wait_until(lambda: not computing.watch.has_run(), lambda: "it runs")
    say(computing, b"work\n")
    wait_until(computing.watch.has_run, lambda: "it does not run")


def test_kill_ends_processes_in_other_sessions() -> None:
    # Nor does it help to ignore requests to end.
    watched = Watched(["sh", "-c", "trap '' TERM INT; setsid sleep 60 & setsid sleep 60 & wait"])
    wait_until(lambda: len(watched.watch.pids()) >= 3, lambda: f"{watched.watch.pids()}")
    began = time.monotonic()
    watched.watch.kill(10.0)
    watched.popen.communicate()
    assert watched.watch.pids() == [] and time.monotonic() - began < 9.0


def test_kill_ends_orphans_with_an_emptied_environment() -> None:
    script = "setsid env -i sleep 60 >/dev/null & echo $!"
    watched = Watched(["sh", "-c", script])
    output, _ = watched.popen.communicate(timeout=30.0)
    assert watched.watch.pids() == [int(output)]
    watched.watch.kill(10.0)
    assert watched.watch.pids() == [] and not os.path.exists(f"/proc/{int(output)}")


def test_is_idle_computing_companion_is_detected(computing: Watched) -> None:
    say(computing, b"rest\n")
    watched = Watched(["sleep", "60"], [computing.popen.pid])
    try:
        assert watched.watch.wait_idle(30.0)
        say(computing, b"work\n")
        assert not watched.watch.is_idle()
        say(computing, b"rest\n")
        assert watched.watch.wait_idle(30.0)
        assert computing.popen.pid not in watched.watch.pids()
    finally:
        watched.watch.kill(10.0)
        watched.popen.communicate()


def test_kill_leaves_no_file_open() -> None:
    before = len(os.listdir("/proc/self/fd"))
    watched = Watched(["sleep", "60"])
    watched.watch.is_idle()
    assert len(os.listdir("/proc/self/fd")) > before + 2  # more than the pipes
    watched.watch.kill(10.0)
    watched.popen.communicate()
    assert len(os.listdir("/proc/self/fd")) == before
