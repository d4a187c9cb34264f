"""Action server without python3-actionlib; robot.test has the tests with it."""

import importlib
import sys
from typing import Any, Iterator, List

import pytest
import rospy

from bot_controller_demo.driving import go_to_server
from bot_controller_demo_msgs.msg import Progress


@pytest.fixture
def without_actionlib(monkeypatch: "pytest.MonkeyPatch") -> Iterator[None]:
    monkeypatch.setitem(sys.modules, "actionlib", None)  # an import of it fails
    importlib.reload(go_to_server)
    yield
    monkeypatch.undo()
    importlib.reload(go_to_server)


@pytest.mark.usefixtures("without_actionlib")
def test_without_actionlib_it_says_so_once_and_does_nothing(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    warnings: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", warnings.append)
    node: Any = object()  # nothing is asked of it
    calls: List[Any] = []
    server = go_to_server.GoToServer(node, calls.append, lambda: calls.append("stop"))
    for _ in range(2):
        server.poll()
        server.publish_progress(Progress(phase=Progress.ARRIVED))
        server.preempt()
    assert calls == []
    assert warnings == ["no action go_to: python3-actionlib is not installed; the rest works"]
