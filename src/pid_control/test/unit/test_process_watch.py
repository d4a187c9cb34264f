"""Tests of the watch of a controller's processes."""

import os
import subprocess
import sys
import time
import uuid
from typing import Iterator, List

import pytest

from nodekit.testing.waiting import wait_until
from pid_control.runner.process_watch import MARK, ProcessWatch

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


class Marked:
    """A process that a watch knows."""

    def __init__(self, command: List[str]) -> None:
        mark = uuid.uuid4().hex
        self.popen = subprocess.Popen(
            command,
            env={**os.environ, MARK: mark},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        self.watch = ProcessWatch(mark)


@pytest.fixture
def computing() -> Iterator[Marked]:
    process = Marked([sys.executable, "-c", LATE_THREADS])
    yield process
    process.popen.kill()
    process.popen.communicate()
    process.watch.close()


def say(process: Marked, line: bytes) -> None:
    assert process.popen.stdin is not None and process.popen.stdout is not None
    process.popen.stdin.write(line)
    process.popen.stdin.flush()
    assert process.popen.stdout.readline() == b"heard\n"


def test_is_idle_new_computing_thread_is_detected(computing: Marked) -> None:
    say(computing, b"rest\n")
    assert computing.watch.wait_idle(30.0)
    say(computing, b"work\n")
    assert not computing.watch.is_idle()
    assert not computing.watch.wait_idle(0.2)
    say(computing, b"rest\n")
    assert computing.watch.wait_idle(30.0)


def test_busy_counts_processor_time(computing: Marked) -> None:
    say(computing, b"work\n")
    before = computing.watch.busy()
    wait_until(lambda: computing.watch.busy() > before + 0.1, lambda: "no processor time")


def test_kill_ends_processes_in_other_sessions() -> None:
    marked = Marked(["sh", "-c", "setsid sleep 60 & setsid sleep 60 & wait"])
    wait_until(lambda: len(marked.watch.pids()) >= 3, lambda: f"{marked.watch.pids()}")
    began = time.monotonic()
    marked.watch.kill(10.0)
    marked.popen.communicate()
    assert marked.watch.pids() == [] and time.monotonic() - began < 9.0
