"""Errors of the command ``fleet_report``, without a graph."""

import sys
from typing import List, Optional

import pytest

from robot_interfaces_demo.commands import fleet_report


class Master:
    """Master of a graph with a talker and without a fleet_monitor."""

    def __init__(self, _name: str) -> None:
        pass

    def lookup_node(self, name: str) -> Optional[str]:
        return "http://localhost:1/" if name == "/talker" else None

    def lookup_service(self, _name: str) -> Optional[str]:
        return None

    def namespaces_offering(self, _service: str) -> List[str]:
        return []


@pytest.mark.parametrize(
    "node, hint",
    [
        ("talker", "/talker is running, but without the service report"),
        ("missing", "no such node is running"),
    ],
)
def test_running_node_without_report_differs_from_missing_node(
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
    node: str,
    hint: str,
) -> None:
    monkeypatch.setattr(fleet_report, "MasterClient", Master)
    monkeypatch.setattr(sys, "argv", ["fleet_report", node])
    with pytest.raises(SystemExit) as ended:
        fleet_report.main()
    assert ended.value.code == fleet_report.NO_ANSWER
    assert capsys.readouterr().err == f"fleet_report: there is no fleet_monitor /{node}; {hint}\n"
