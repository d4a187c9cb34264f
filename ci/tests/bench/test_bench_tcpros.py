"""The subscriber of ci/bench, which speaks TCPROS itself."""

import os
import socket
import struct
import threading
import xmlrpc.server

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ci.benchmark import tcpros
from ci.benchmark.recorder import wait_until


@given(st.lists(st.binary(max_size=20), max_size=10), st.integers(0, 30))
def test_messages_are_whole_wherever_the_stream_is_cut(messages, cut):
    stream = b"".join(struct.pack("<I", len(message)) + message for message in messages)
    found, rest = tcpros.split_messages(stream[:cut])
    more, end = tcpros.split_messages(rest + stream[cut:])
    assert found + more == messages
    assert end == b""


def test_received_messages_come_with_their_moment_until_the_end():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(struct.pack("<I", 2) + b"ab" + struct.pack("<I", 1))
        theirs.shutdown(socket.SHUT_WR)
        ((moment, messages),) = tcpros.receive_messages(ours)
    assert messages == [b"ab"] and moment > 0.0


def serve(**functions):
    server = xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    for name, function in functions.items():
        server.register_function(function, name)
    threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    return server, f"http://localhost:{server.server_address[1]}"


@pytest.fixture(name="master")
def make_master():
    """A master without publishers."""

    def accept(*_arguments):
        return 1, "", []

    server, uri = serve(registerSubscriber=accept, unregisterSubscriber=accept)
    yield uri
    server.shutdown()
    server.server_close()


def test_a_port_that_comes_back_is_connected_again(master, monkeypatch):
    connected = []
    monkeypatch.setattr(tcpros.Node, "_connect", lambda self, topic, uri: connected.append(uri))
    node = tcpros.Node("/node", master)
    for uris in (["a"], ["a", "b"], ["b"], ["b", "a"]):
        node.update_publishers("/master", "/topic", uris)
    node.close()
    wait_until(lambda: len(connected) >= 3, 30.0, "connection")
    assert sorted(connected) == ["a", "a", "b"]


def test_a_publisher_that_answers_nonsense_is_tried_again_quietly(master, capfd):
    calls = []
    server, uri = serve(requestTopic=lambda *_: calls.append(0) or (0, "busy", 0))
    node = tcpros.Node("/node", master)
    node.subscribe("/topic", "std_msgs/Empty", lambda connection: None)
    node.update_publishers("/master", "/topic", [uri])
    wait_until(lambda: len(calls) >= 2, 30.0, "second try")
    node.close()
    server.shutdown()
    server.server_close()
    assert capfd.readouterr().err == ""


def test_a_closed_node_leaves_no_socket_and_no_thread(master):
    before = len(os.listdir("/proc/self/fd")), threading.active_count()
    for _ in range(5):
        tcpros.Node("/node", master).close()

    def is_as_before():
        return (len(os.listdir("/proc/self/fd")), threading.active_count()) <= before

    wait_until(is_as_before, 30.0, "end of the threads")
