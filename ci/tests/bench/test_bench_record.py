"""Tests of the records that processes write for ci/bench."""

import os
import signal
import subprocess
import sys
import time

from ci.benchmark import processes, record
from ci.benchmark.recorder import wait_until

#: Program that counts until it is stopped.
COUNT = """
import sys, time
from ci.benchmark.record import Record
out = Record(sys.argv[1])
number = 0.0
while True:
    out.add(number)
    number += 1.0
    time.sleep(0.001)
"""


def test_a_record_is_read_while_it_is_written(tmp_path):
    file = tmp_path / "record"
    out = record.Record(str(file))
    assert record.read(file) == []
    before = time.monotonic()
    out.add(0.0)
    out.add(2.5)
    first, second = record.read(file)
    assert (first.value, second.value) == (0.0, 2.5)
    assert before <= first.moment <= second.moment <= time.monotonic()
    assert record.Record(str(file)) and record.read(file) == []


def test_a_paused_process_can_be_resumed_and_ended(tmp_path):
    file = tmp_path / "record"
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    process = subprocess.Popen([sys.executable, "-c", COUNT, str(file)], env=environment)

    def count():
        return len(record.read(file))

    def is_stopped():
        return os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOHANG | os.WNOWAIT)

    wait_until(lambda: count() > 3, 30.0, "samples")
    with processes.paused([process.pid]):
        wait_until(is_stopped, 30.0, "stop")
        still = count()
        with processes.resumed([process.pid]):
            wait_until(lambda: count() > still, 30.0, "samples")
        wait_until(is_stopped, 30.0, "stop")
    process.send_signal(signal.SIGTERM)
    assert process.wait(30.0) == -signal.SIGTERM
