"""Responses to pages before the scope is ready."""

from typing import Any, Dict, List

from topic_scope.web.http_server import PlaceholderScope

URI = "http://localhost:11311"
SENTENCE = f"There is no ROS master at {URI} yet: the scope waits for it."


class FakeConnection:
    """Connection that stores its messages about the master."""

    def __init__(self) -> None:
        self.texts: List[str] = []

    def send(self, messages: List[Dict[str, Any]]) -> None:
        self.texts += [message["text"] for message in messages if message["type"] == "master"]


def test_missing_master_is_reported_only_once_known() -> None:
    waiting = PlaceholderScope(URI, 10.0)
    early, late, gone = FakeConnection(), FakeConnection(), FakeConnection()
    waiting.open(early)
    waiting.open(gone)
    waiting.close(gone)
    assert early.texts == [""]
    waiting.miss()
    waiting.open(late)
    assert early.texts == ["", SENTENCE]
    assert late.texts == [SENTENCE]
    assert gone.texts == [""]
