"""Tests of warnings about announced publishers that are never connected."""

import contextlib
import xmlrpc.client
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Iterator, List

import pytest
import rospy

from nodekit.rospy_internals import connection_watch
from nodekit.testing.processes import Master, Process, free_port
from nodekit.testing.waiting import wait_until

NODE = """
import nodekit
from std_msgs.msg import String

class Some:
    def __init__(self, node):
        node.create_subscription("topic", String, print)

nodekit.run("some", Some)
"""
PUBLISHER = """
import nodekit
from std_msgs.msg import Float32

nodekit.run("other", lambda node: node.create_publisher("topic", Float32))
"""
#: An address for documentation, RFC 5737, which no packet reaches.
ELSEWHERE = "http://192.0.2.77:4711/"


@pytest.fixture()
def master() -> Iterator[Master]:
    server = Master()
    try:
        yield server
    finally:
        server.kill()


@contextlib.contextmanager
def running(master: Master, folder: Path, *programs: str) -> Iterator[List[Process]]:
    """Run programs; end them afterwards."""
    processes = []
    try:
        for number, program in enumerate(programs):
            path = folder / f"node{number}.py"
            path.write_text(program)
            processes.append(Process(str(path), [], {"ROS_MASTER_URI": master.uri}))
        yield processes
    finally:
        for process in processes:
            process.end()


def test_publisher_that_was_warned_of_is_not_waited_for_again(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    warnings: List[str] = []
    subscribed = SimpleNamespace(get_subscriber_impl=lambda _name: SimpleNamespace(connections=[]))
    monkeypatch.setattr(connection_watch, "PATIENCE_S", 0.0)
    monkeypatch.setattr(connection_watch, "_PERIOD_S", 0.001)
    monkeypatch.setattr(connection_watch, "get_topic_manager", lambda: subscribed)
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: warnings.append(text % values))

    def request(calls: List[Any]) -> List[Any]:
        if calls == [("getSystemState",)]:
            return [(1, "", ([("/topic", ["/elsewhere"])], [], []))]
        return [(1, "", "http://elsewhere:1/")]

    watch = connection_watch.ConnectionWatch(request)
    for reason in ("no route", "no route any longer"):
        watch.fail("/topic", "http://elsewhere:1/", reason)
        watch.begin("/topic", "http://elsewhere:1/")
        wait_until(lambda: not watch._is_running, lambda: "still waiting")
    (warning,) = warnings
    assert "/elsewhere at http://elsewhere:1/ (no route)" in warning


@pytest.mark.extended
@pytest.mark.parametrize("uri", [ELSEWHERE, ""], ids=["no route", "nothing listens"])
def test_subscriber_of_an_unreachable_publisher_warns_once(
    master: Master, tmp_path: Path, uri: str
) -> None:
    uri = uri or f"http://localhost:{free_port()}/"
    client: Any = xmlrpc.client.ServerProxy(master.uri)
    assert client.registerPublisher("/elsewhere", "/topic", "std_msgs/String", uri)[0] == 1
    with running(master, tmp_path, NODE) as (node,):
        start = f"topic /topic: no connection to publisher /elsewhere at {uri} ("
        node.wait_for_log("WARN", start, "check that node, and ROS_IP or ROS_HOSTNAME")
        assert client.unregisterPublisher("/elsewhere", "/topic", uri)[0] == 1
        assert client.registerPublisher("/elsewhere", "/topic", "std_msgs/String", uri)[0] == 1
        assert node.interrupt() == 0
        assert len(node.logged("no connection to publisher")) == 1


@pytest.mark.extended
def test_subscriber_of_another_type_warns_at_its_own_end(master: Master, tmp_path: Path) -> None:
    with running(master, tmp_path, NODE, PUBLISHER) as (node, _publisher):
        node.wait_for_log(
            "WARN",
            "topic /topic: no connection to publisher /other at ",
            "type",
            "use the same version of the message type on both sides",
        )
