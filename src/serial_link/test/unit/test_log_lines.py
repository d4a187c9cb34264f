"""Log of a board, on rosout and on the console."""

from types import SimpleNamespace
from typing import Any, List

import pytest
import rospy
from rosgraph_msgs.msg import Log

from serial_link.endpoints import log_lines
from serial_link.endpoints.log_lines import LogLines
from serial_link.negotiation.payloads import DEBUG, ERROR, FATAL, INFO, WARN


class FakeScope:
    """Scope whose publisher records the lines."""

    def __init__(self) -> None:
        self.published: List[Log] = []

    def create_publisher(self, name: str, _class: Any) -> "FakeScope":
        assert name == "/rosout"
        return self

    def publish(self, line: Log) -> None:
        self.published.append(line)


@pytest.fixture
def scope(monkeypatch: "pytest.MonkeyPatch") -> Any:
    monkeypatch.setattr(rospy, "get_rostime", lambda: rospy.Time(12, 500000000))
    monkeypatch.setattr(log_lines, "time", SimpleNamespace(monotonic=lambda: 100.0))
    return FakeScope()


def test_line_is_published_unchanged_and_printed_without_control_characters(
    scope: Any, capsys: "pytest.CaptureFixture[str]"
) -> None:
    lines = LogLines(scope, "/node/board")
    lines.write(ERROR, "hot\x1b[2J\nµ")
    lines.write(DEBUG, "quiet")
    assert capsys.readouterr().out == "[ERROR] [12.500000]: /node/board: hot [2J µ\n"
    assert [line.msg for line in scope.published] == ["hot\x1b[2J\nµ", "quiet"]
    first = scope.published[0]
    assert (first.name, first.level) == ("/node/board", Log.ERROR)
    assert first.header.stamp == rospy.Time(12, 500000000)


@pytest.mark.parametrize(
    "level, number, word",
    [
        (INFO, Log.INFO, "INFO"),
        (WARN, Log.WARN, "WARN"),
        (ERROR, Log.ERROR, "ERROR"),
        (FATAL, Log.FATAL, "FATAL"),
    ],
)
def test_line_keeps_its_level(
    scope: Any, level: int, number: int, word: str, capsys: "pytest.CaptureFixture[str]"
) -> None:
    LogLines(scope, "/node/board").write(level, "text")
    assert scope.published[0].level == number
    assert capsys.readouterr().out.startswith(f"[{word}] ")


def test_lines_beyond_20_a_second_are_counted_until_the_next_second(
    scope: Any, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    lines = LogLines(scope, "/node/board")
    for number in range(23):
        lines.write(INFO, f"line {number}")
    monkeypatch.setattr(log_lines, "time", SimpleNamespace(monotonic=lambda: 101.0))
    for number in range(20):
        lines.write(INFO, f"next {number}")
    monkeypatch.setattr(log_lines, "time", SimpleNamespace(monotonic=lambda: 102.0))
    lines.write(INFO, "last")
    texts = [line.msg for line in scope.published]
    assert texts[19:22] == ["line 19", "... and 3 more lines in that second", "next 0"]
    assert texts[-2:] == ["next 19", "last"]
