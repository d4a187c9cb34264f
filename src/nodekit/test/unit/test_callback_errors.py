"""Tests of the rate-limited log of exceptions of callbacks."""

from typing import Any, List

import pytest
import rospy
import rospy.core

from nodekit import throttle
from nodekit.groups.callback_groups import Group
from nodekit.messaging import callback_errors
from nodekit.node.callbacks import Callback


@pytest.fixture()
def logged(monkeypatch: "pytest.MonkeyPatch") -> List[str]:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logerr", lambda text, *args: lines.append(text % args))
    return lines


def fail(what: callback_errors.CallbackErrors) -> None:
    try:
        raise ValueError("on purpose")
    except ValueError:
        what.record("/topic")


def test_failures_are_counted_and_logged_at_times(
    logged: List[str], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    now = [100.0]
    monkeypatch.setattr(throttle.time, "monotonic", lambda: now[0])
    what = callback_errors.CallbackErrors()
    for moment in (100.0, 101.0, 104.9, 105.0):
        now[0] = moment
        fail(what)
    assert [line.splitlines()[0] for line in logged] == [
        "/topic failed, 1 times so far:",
        "/topic failed, 4 times so far:",
    ]
    assert logged[0].endswith("ValueError: on purpose")


def test_failure_during_shutdown_is_only_counted(
    logged: List[str], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    # rospy calls shutdown hooks before is_shutdown() is true.
    monkeypatch.setattr(rospy.core, "_in_shutdown", True)
    assert not rospy.is_shutdown()
    what: Any = callback_errors.CallbackErrors()
    fail(what)
    assert (what.count, logged) == (1, [])


@pytest.mark.parametrize("call", [Callback.call, Callback.call_inside])
def test_failure_because_of_a_closed_node_is_only_counted(logged: List[str], call: Any) -> None:
    def publish_to_what_is_closed() -> None:
        callback.close()
        raise rospy.ROSException("publish() to a closed publisher")

    callback = Callback(Group(), publish_to_what_is_closed, "/topic")
    call(callback)
    assert (callback.errors.count, logged) == (1, [])
