"""Processes that tests start."""

import contextlib

import pytest

from nodekit.testing import processes


def test_two_masters_share_no_port(monkeypatch: "pytest.MonkeyPatch") -> None:
    first, second = processes.free_ports(2)
    ports = iter((first, first, second))  # as where both were looked for at the same moment
    monkeypatch.setattr(processes, "free_port", lambda: next(ports))
    with contextlib.ExitStack() as ends:
        uris = []
        for _ in range(2):
            master = processes.Master()
            ends.callback(master.kill)
            uris.append(master.uri)
    assert uris == [f"http://localhost:{port}/" for port in (first, second)]
