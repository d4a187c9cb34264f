"""Tests of the helper for processes."""

import contextlib
import pathlib
import socket
import subprocess
import sys

import pytest

from nodekit import master_process
from nodekit.testing import processes
from nodekit.testing.waiting import TIMEOUT_S


def test_free_port_stays_free_where_others_take_any(monkeypatch: "pytest.MonkeyPatch") -> None:
    bounds = pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range").read_text()
    first_given = int(bounds.split()[0])
    if first_given < 32_768:
        pytest.skip(f"this machine has been told to give any port from {first_given}")
    assert max(processes.free_ports(100)) < first_given
    first, second, third = processes.free_ports(3)
    with socket.socket() as taken:
        taken.bind(("localhost", first))
        found = iter((first, second, second, third))
        monkeypatch.setattr(master_process._random, "choice", lambda _ports: next(found))
        assert processes.free_ports(2) == [second, third]


def test_two_masters_share_no_port(monkeypatch: "pytest.MonkeyPatch") -> None:
    first, second = processes.free_ports(2)
    ports = iter((first, first, second))  # as where both were looked for at the same moment
    monkeypatch.setattr(master_process, "free_ports", lambda _count: [next(ports)])
    with contextlib.ExitStack() as ends:
        uris = []
        for _ in range(2):
            master = processes.Master()
            ends.callback(master.kill)
            uris.append(master.uri)
    assert uris == [f"http://localhost:{port}/" for port in (first, second)]


#: Prints a line and then works in ten threads until its input ends.
BUSY = """
import sys, threading

def work():
    while True:
        sum(range(1000))

for _ in range(10):
    threading.Thread(target=work, daemon=True).start()
print("ready", flush=True)
sys.stdin.read()
"""


def test_process_hangs_with_all_its_threads_and_resumes() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", BUSY], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as busy:
        assert busy.stdin is not None and busy.stdout is not None
        assert busy.stdout.readline() == b"ready\n"
        for _ in range(20):
            with contextlib.suppress(ZeroDivisionError), processes.hanging(busy.pid):
                assert processes.is_stopped(busy.pid)
                raise ZeroDivisionError  # a test that fails leaves it no less
            assert not processes.is_stopped(busy.pid)
        with processes.hanging(busy.pid):
            busy.kill()
            assert busy.wait(TIMEOUT_S) < 0
