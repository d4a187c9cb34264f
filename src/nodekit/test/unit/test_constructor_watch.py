"""Tests of the warning about a constructor that waits for a message."""

import threading
import time
from pathlib import Path
from typing import Any, List

import pytest
import rospy

from nodekit.process import constructor_watch
from nodekit.process.constructor_watch import ConstructorWatch
from nodekit.testing.processes import Master, Process
from nodekit.testing.waiting import in_thread, wait_until

NODE = """
import threading
import nodekit
from std_msgs.msg import String

class Some:
    def __init__(self, node):
        heard = threading.Event()
        node.create_subscription("topic", String, lambda message: heard.set())
        heard.wait()

nodekit.run("some", Some)
"""


@pytest.fixture()
def logged(monkeypatch: "pytest.MonkeyPatch") -> List[str]:
    lines: List[str] = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: lines.append(text % args))
    monkeypatch.setattr(constructor_watch, "PATIENCE_S", 0.1)
    return lines


@pytest.mark.extended
def test_constructor_that_waits_for_its_own_subscription_is_named_with_its_line(
    tmp_path: Path,
) -> None:
    path = tmp_path / "some_node.py"
    path.write_text(NODE)
    master = Master()
    node = Process(str(path), [], {"ROS_MASTER_URI": master.uri})
    try:
        node.wait_for_log("WARN", f"the constructor has waited for 5 s at {path}:10; ")
        node.interrupt()
        assert len(node.logged("the constructor has waited")) == 1
    finally:
        node.end()
        master.kill()


def test_waiting_constructor_is_warned_of_once(logged: List[str]) -> None:
    watch, begun, may_end = ConstructorWatch(), threading.Event(), threading.Event()

    def construct() -> None:
        with watch.running():
            begun.set()
            may_end.wait()

    thread = in_thread(construct)
    assert begun.wait(20.0)
    wait_until(lambda: watch.warn_if_waiting() or logged, lambda: "no warning")
    watch.warn_if_waiting()
    may_end.set()
    thread.join()
    assert len(logged) == 1 and __file__ in logged[0]


def test_busy_constructor_is_not_warned_of(
    logged: List[str], monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(time, "clock_gettime", lambda clock, times=iter((1.0, 9.0)): next(times))
    watch = ConstructorWatch()
    with watch.running():
        time.sleep(0.2)
        watch.warn_if_waiting()
    assert logged == []


def test_constructor_that_has_returned_is_not_warned_of(logged: List[str]) -> None:
    watch: Any = ConstructorWatch()
    watch.warn_if_waiting()
    with watch.running():
        pass
    watch.warn_if_waiting()
    assert logged == []
