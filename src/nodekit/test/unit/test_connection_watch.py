"""Tests of warnings about announced publishers that are never connected."""

import contextlib
import xmlrpc.client
from pathlib import Path
from typing import Any, Iterator, List

import pytest

from nodekit.testing.processes import Master, Process, free_port

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
