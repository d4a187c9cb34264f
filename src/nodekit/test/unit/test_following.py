"""Who follows a key may do with its value what they like."""

from typing import Any, List
from unittest import mock

from nodekit.live.following import Following
from nodekit.parameters.reconciler import Seen


def test_what_a_callback_changes_is_its_own() -> None:
    watcher = mock.Mock(**{"first_reading.return_value": ["one"]})
    told: List[Any] = []
    following = Following("/key", watcher, lambda value: told.append(value.append("mine")))
    first = following.first()
    assert first == ["one"]
    first.append("mine")
    assert not following._is_news(["one"])
    following._take(Seen(["two"], [], False, 0.0))
    assert told and not following._is_news(["two"])
    following._take(Seen(["two"], [], False, 0.0))
    assert len(told) == 1
