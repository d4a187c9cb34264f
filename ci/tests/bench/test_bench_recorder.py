"""Tests of the subscriber of ci/bench, a TCPROS client."""

import os
import struct
import threading
import xmlrpc.server

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ci.benchmark.recorder import Recorder, split_messages, wait_until


@given(st.lists(st.binary(max_size=20), max_size=10), st.integers(0, 30))
def test_messages_are_whole_wherever_the_stream_is_cut(messages, cut):
    stream = b"".join(struct.pack("<I", len(message)) + message for message in messages)
    found, rest = split_messages(stream[:cut])
    more, end = split_messages(rest + stream[cut:])
    assert found + more == messages
    assert end == b""


def serve(**functions):
    server = xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    for name, function in functions.items():
        server.register_function(function, name)
    threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    return server, f"http://localhost:{server.server_address[1]}"


@pytest.fixture(name="master")
def make_master():
    """Return a master without publishers."""

    def accept(*_arguments):
        return 1, "", []

    server, uri = serve(registerSubscriber=accept, unregisterSubscriber=accept)
    yield uri
    server.shutdown()
    server.server_close()


def recorder(master):
    return Recorder("/recorder", master, "/topic", "std_msgs/Empty")


def test_returning_port_is_connected_again(master, monkeypatch):
    connected = []
    monkeypatch.setattr(Recorder, "_connect", lambda self, uri: connected.append(uri))
    with recorder(master) as observer:
        for uris in (["a"], ["a", "b"], ["b"], ["b", "a"]):
            observer.update_publishers(uris)
    wait_until(lambda: len(connected) >= 3, 30.0, "connection")
    assert sorted(connected) == ["a", "a", "b"]


def test_a_publisher_that_answers_nonsense_is_tried_again_quietly(master, capfd):
    calls = []
    server, uri = serve(requestTopic=lambda *_: calls.append(0) or (0, "busy", 0))
    with recorder(master) as observer:
        observer.update_publishers([uri])
        wait_until(lambda: len(calls) >= 2, 30.0, "second try")
    server.shutdown()
    server.server_close()
    assert capfd.readouterr().err == ""


def test_a_closed_recorder_leaves_no_socket_and_no_thread(master):
    before = len(os.listdir("/proc/self/fd")), threading.active_count()
    for _ in range(5):
        with recorder(master):
            pass

    def is_as_before():
        return (len(os.listdir("/proc/self/fd")), threading.active_count()) <= before

    wait_until(is_as_before, 30.0, "end of the threads")
