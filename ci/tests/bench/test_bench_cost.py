"""Tests of the resource usage that ci/bench reads."""

import os
import subprocess
import sys

import pytest

from ci.benchmark.cost import cpu_time

#: Uses processor time in threads that end, and prints it [s].
BURN = """
import threading, time
def burn():
    end = time.thread_time() + 0.05
    while time.thread_time() < end:
        pass
for _ in range(4):
    thread = threading.Thread(target=burn)
    thread.start()
    thread.join()
print(time.process_time(), flush=True)
input()
"""


def test_time_of_ended_threads_counts():
    process = subprocess.Popen(
        [sys.executable, "-c", BURN], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdout is not None
    used = float(process.stdout.readline())
    assert cpu_time([process.pid]) == pytest.approx(used, abs=0.02)
    process.communicate(b"\n", timeout=10)


def test_a_process_that_ends_while_it_is_read_costs_nothing(monkeypatch):
    process = subprocess.Popen(["sleep", "60"])

    def end_first(real):
        def listing(*arguments):
            process.kill()
            process.wait()
            return real(*arguments)

        return listing

    for name in ("scandir", "listdir"):
        monkeypatch.setattr(os, name, end_first(getattr(os, name)))
    assert cpu_time([process.pid, os.getpid()]) > 0.0
    process.kill()
    process.wait()
    assert cpu_time([process.pid]) == 0.0
