"""Tests of errors of the command ``rosrun nodekit callbacks``, without a graph."""

import sys
from typing import Any, List, Optional

import pytest

from nodekit.commands import callbacks as command


class Master:
    """Master with a talker in a process, a hosted node, and nodes that have an executor."""

    executors: List[str] = []

    def __init__(self, _name: str) -> None:
        pass

    def lookup_node(self, name: str) -> Optional[str]:
        return "http://localhost:1/" if name == "/talker" else None

    def lookup_service(self, name: str) -> Optional[str]:
        return "rosrpc://localhost:1" if name == "/hosted/describe" else None

    def namespaces_offering(self, _service: str) -> List[str]:
        return self.executors


@pytest.mark.parametrize("executors", [[], ["/dock"]])
@pytest.mark.parametrize(
    "name, problem",
    [
        ("/talker", "/talker runs but has no executor; add it to an executor in its program: "),
        ("talker", "/talker runs but has no executor; add it to an executor in its program: "),
        ("/hosted", "/hosted runs but has no executor; add it to an executor in its program: "),
        ("/missing", "/missing has no executor; "),
    ],
)
def test_node_without_executor_is_distinguished_from_missing_node(
    monkeypatch: "pytest.MonkeyPatch", executors: List[str], name: str, problem: str
) -> None:
    monkeypatch.setattr(command, "MasterClient", Master)
    monkeypatch.setattr(Master, "executors", executors)
    monkeypatch.setattr(sys, "argv", ["callbacks", name])
    with pytest.raises(SystemExit) as ended:
        command.main()
    if name == "/missing":
        problem += "there is /dock" if executors else "no such node is running"
    assert str(ended.value).startswith("callbacks: " + problem)


def test_hint_for_running_node_names_the_missing_service() -> None:
    master: Any = Master("/test")
    hint = command.service_hint(master, "change", "/talker/")
    assert hint == "/talker is running, but without the service change"
