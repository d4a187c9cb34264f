"""Who follows a key may do with its value what they like."""

import contextlib
from typing import Any, List
from unittest import mock

import pytest

from nodekit.master import MasterUnreachable
from nodekit.parameter_server.followers import Entry, Follower
from nodekit.parameter_server.following import Following
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


@pytest.mark.parametrize("fails", [False, True])
def test_who_asks_to_be_told_while_being_told_is_told_once_more(fails: bool) -> None:
    def take(seen: Seen) -> bool:
        entry.due = True  # as another thread does it
        if fails:
            raise MasterUnreachable("on purpose")
        return True

    entry = Entry(Follower("/key", lambda raw: False, take))
    with pytest.raises(MasterUnreachable) if fails else contextlib.nullcontext():
        assert entry.tell("value", 0.0)
    assert entry.is_due


def test_who_is_not_done_is_told_once_more() -> None:
    answers = [False, True]
    entry = Entry(Follower("/key", lambda raw: False, lambda seen: answers.pop(0)))
    assert not entry.tell("value", 0.0) and entry.is_due
    assert entry.tell("value", 0.0) and not entry.is_due
