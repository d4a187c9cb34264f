"""Tests of followed parameters: values are copies that the callback may change."""

import contextlib
from typing import Any, List
from unittest import mock

import pytest

from nodekit.master import MasterUnreachable
from nodekit.parameter_server.followed_parameter import FollowedParameter
from nodekit.parameter_server.watched_key import WatchedKey
from nodekit.parameters.reconciler import Observation


def test_callback_gets_its_own_copy() -> None:
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
def test_request_during_a_notification_notifies_once_more(fails: bool) -> None:
    def on_reading(seen: Observation) -> bool:
        watched.due = True  # as another thread does it
        if fails:
            raise MasterUnreachable("on purpose")
        return True

    watched = WatchedKey("/key", lambda raw: False, on_reading)
    with pytest.raises(MasterUnreachable) if fails else contextlib.nullcontext():
        assert watched.hand_over("value", 0.0)
    assert watched.is_due


def test_unfinished_listener_is_notified_once_more() -> None:
    answers = [False, True]
    watched = WatchedKey("/key", lambda raw: False, lambda seen: answers.pop(0))
    assert not watched.hand_over("value", 0.0) and watched.is_due
    assert watched.hand_over("value", 0.0) and not watched.is_due
