"""Tests of Throttle: one limit for each instance and key."""

import math
from typing import List

import pytest
import rospy
from std_msgs.msg import Float32

from nodekit import Node, throttle
from nodekit.groups.callback_groups import Group
from nodekit.node import callbacks
from nodekit.node.names import Names


@pytest.fixture()
def logged(monkeypatch: "pytest.MonkeyPatch") -> List[str]:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: lines.append(text % args))
    return lines


def test_throttle_is_due_once_in_a_period(monkeypatch: "pytest.MonkeyPatch") -> None:
    now = [100.0]
    monkeypatch.setattr(throttle.time, "monotonic", lambda: now[0])
    what = throttle.Throttle(10.0)
    due = []
    for now[0] in (100.0, 100.1, 109.9, 110.0, 119.9, 300.0, 301.0):
        due.append(what.is_due())
    assert due == [True, False, False, True, False, True, False]


def test_keys_of_one_throttle_are_due_independently() -> None:
    limit = throttle.Throttle(10.0)
    assert [limit.is_due(key) for key in ("late", "lost", "late", None, "lost", None)] == [
        True,
        True,
        False,
        True,
        False,
        False,
    ]


def test_two_owners_of_the_same_warning_are_both_due() -> None:
    owners = [throttle.Throttle(10.0) for _ in range(2)]
    assert [owner.is_due("late") for owner in owners * 2] == [True, True, False, False]


def test_expired_keys_are_removed(monkeypatch: "pytest.MonkeyPatch") -> None:
    now = [100.0]
    monkeypatch.setattr(throttle.time, "monotonic", lambda: now[0])
    limit = throttle.Throttle(10.0)
    for now[0] in range(100, 1000):
        assert limit.is_due(now[0])
    assert len(limit._quiet_until) <= throttle._PRUNE_ABOVE + 1
    assert not limit.is_due(995)


def test_finite_subscription_warns_once_for_each_topic(logged: List[str]) -> None:
    node = Node(Names("/space/node", True))
    heard: List[float] = []
    recorders = [
        node.create_subscription(
            name, Float32, lambda message: heard.append(message.data), finite=True
        )
        for name in ("one", "other")
    ]
    for number in (math.nan, math.inf, -math.inf, 1.0):
        for recorder in recorders:
            recorder._receive([Float32(number)], True)
    assert heard == [1.0, 1.0]
    assert logged == [
        "/space/one: data: nan is not finite and is ignored",
        "/space/other: data: nan is not finite and is ignored",
    ]


def test_slow_callback_keeps_newest_messages(
    logged: List[str], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(callbacks, "MOST_KEPT", 3)
    group, heard = Group(), []  # type: CallbackGroup, List[Any]
    slow = callbacks.SubscriptionCallback(group, heard.append, "/one", batches=True)
    with group:
        for messages in ([1], [2, 3], [], [4, 5]):
            slow.receive(messages, False)
    assert heard == [[3, 4, 5]]
    slow.receive([6], False)
    assert heard[1:] == [[6]]


def test_slow_callback_warns_once_for_each_topic(
    logged: List[str], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(callbacks, "MOST_KEPT", 0)
    group = Group()
    slow = [
        callbacks.SubscriptionCallback(group, lambda message: None, name, batches=False)
        for name in ("/one", "/other")
    ]
    with group:
        for message in range(3):  # type: Any
            for each in slow:
                each.receive([message], False)
    text = "callback is too slow, messages are dropped"
    assert logged == [f"/one: {text}", f"/other: {text}"]
