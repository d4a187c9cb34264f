"""Status of a board on /diagnostics, and the log lines about its faults."""

import logging
from types import SimpleNamespace
from typing import Dict

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from serial_link.nodes import serial_node


class FakeLink:
    """Link with given counters."""

    port_name, trouble = "/dev/board", ""

    def __init__(self) -> None:
        usual = {"received": 5, "received bytes": 60, "sent": 2, "sent bytes": 20}
        self.figures = {**usual, "openings": 1, "asked": 3, "malformed": 0}

    def all_counters(self) -> Dict[str, int]:
        return dict(self.figures)


def test_new_faults_are_a_warning_once_and_are_logged_at_most_every_10_s(
    monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    caplog.set_level(logging.INFO, "rosout")
    now = 0.0
    monkeypatch.setattr(serial_node, "time", SimpleNamespace(monotonic=lambda: now))
    link = FakeLink()
    board = serial_node._Board("left", link, None)  # type: ignore[arg-type]

    def status() -> DiagnosticStatus:
        return board.status("/serial_node")

    first = status()
    assert (first.level, first.message) == (DiagnosticStatus.OK, "synchronized")
    assert (first.name, first.hardware_id) == ("serial_node: left", "/dev/board")
    values = {value.key: value.value for value in first.values}
    assert values == {name: str(count) for name, count in link.figures.items()}
    assert list(values) == sorted(values)
    for now in range(1, 12):
        link.figures["malformed"] = now
        assert (status().level, status().level) == (DiagnosticStatus.WARN, DiagnosticStatus.OK)
    now = 100
    assert status().level == DiagnosticStatus.OK  # nothing new is to be logged
    lines = [line for line in caplog.messages if "malformed" in line]
    assert lines == [
        f"/dev/board: 5 frames received, 2 sent; malformed {count}" for count in (1, 11)
    ]
    link.trouble = "the board sends nothing"
    assert (status().level, status().message) == (DiagnosticStatus.ERROR, link.trouble)
