"""Tests of followed parameters: values are copies that the callback may change."""

import contextlib
from typing import Any, List
from unittest import mock

import pytest

from nodekit.master import MasterUnreachable
from nodekit.parameter_server.followed_parameter import FollowedParameter
from nodekit.parameter_server.watched_key import WatchedKey
from nodekit.parameters.reconciler import Observation


def test_what_a_callback_changes_is_its_own() -> None:
    watcher = mock.Mock(**{"first_reading.return_value": ["one"]})
    told: List[Any] = []
    followed = FollowedParameter("/key", watcher, lambda value: told.append(value.append("mine")))
    first = followed.first()
    assert first == ["one"]
    first.append("mine")
    assert not followed._is_news(["one"])
    followed._on_reading(Observation(["two"], [], False, 0.0))
    assert told and not followed._is_news(["two"])
    followed._on_reading(Observation(["two"], [], False, 0.0))
    assert len(told) == 1


@pytest.mark.parametrize("fails", [False, True])
def test_who_asks_to_be_told_while_being_told_is_told_once_more(fails: bool) -> None:
    def on_reading(seen: Observation) -> bool:
        watched.due = True  # as another thread does it
        if fails:
            raise MasterUnreachable("on purpose")
        return True

    watched = WatchedKey("/key", lambda raw: False, on_reading)
    with pytest.raises(MasterUnreachable) if fails else contextlib.nullcontext():
        assert watched.hand_over("value", 0.0)
    assert watched.is_due


def test_who_is_not_done_is_told_once_more() -> None:
    answers = [False, True]
    watched = WatchedKey("/key", lambda raw: False, lambda seen: answers.pop(0))
    assert not watched.hand_over("value", 0.0) and watched.is_due
    assert watched.hand_over("value", 0.0) and not watched.is_due
