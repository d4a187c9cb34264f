"""Tests of how ci/bench's own node reads and writes TCPROS."""

import importlib
import io
import os
import socket
import struct
import sys
import threading
import time
import xmlrpc.client
import xmlrpc.server

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ci.benchmark import peer_programs as peers
from ci.benchmark import tcpros
from ci.benchmark.observers import wait_until

names = st.text("abcdefghij_", min_size=1, max_size=8)


@given(st.dictionaries(names, st.text("abc=/* \n", max_size=20), max_size=6))
def test_headers_come_back_as_they_were(fields):
    encoded = tcpros.encode_header(fields)
    assert struct.unpack_from("<I", encoded) == (len(encoded) - 4,)
    assert tcpros.decode_header(encoded[4:]) == fields


@given(st.lists(st.binary(max_size=20), max_size=10), st.integers(0, 30))
def test_messages_are_whole_wherever_the_stream_is_cut(messages, cut):
    stream = b"".join(struct.pack("<I", len(message)) + message for message in messages)
    found, rest = tcpros.split_messages(stream[:cut])
    more, end = tcpros.split_messages(rest + stream[cut:])
    assert found + more == messages
    assert end == b""


def test_a_port_that_comes_back_is_connected_to_anew(monkeypatch):
    connected = []
    monkeypatch.setattr(tcpros.Node, "_connect", lambda self, topic, uri: connected.append(uri))
    node = tcpros.Node("/node", "http://localhost:1")
    for uris in (["a"], ["a", "b"], ["b"], ["b", "a"]):
        node.publisherUpdate("/master", "/topic", uris)
    node.close()
    wait_until(lambda: len(connected) >= 3, 30.0, "connection")
    assert sorted(connected) == ["a", "a", "b"]


@pytest.fixture(autouse=True)
def quick_to_close(monkeypatch):
    monkeypatch.setattr(tcpros, "CLOSING_LIMIT", 0.01)


@pytest.fixture
def master():
    """A master that takes every registration."""
    server = xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    server.register_instance(type("Master", (), {"_dispatch": lambda *_: (1, "", [])})())
    threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    yield f"http://localhost:{server.server_address[1]}"
    server.shutdown()
    server.server_close()


def tcpros_port(node):
    return node.requestTopic("", "", [])[2][2]


def say_nothing(_connection):
    pass


def hang_up(_connection):
    _connection.close()


def send_half_a_header(connection):
    connection.sendall(struct.pack("<I", 100) + b"half")
    connection.close()


def ask_for_an_unknown_topic(connection):
    connection.sendall(tcpros.encode_header({"topic": "/other"}))


def send_nonsense(connection):
    connection.sendall(b"GET / HTTP/1.1\r\n\r\n" + bytes(range(256)))


@pytest.mark.parametrize(
    "misbehave",
    [say_nothing, hang_up, send_half_a_header, ask_for_an_unknown_topic, send_nonsense],
)
def test_one_bad_subscriber_keeps_no_other_waiting(master, misbehave, capfd):
    node = tcpros.Node("/node", master)
    node.advertise("/topic", tcpros.TopicType("std_msgs/Empty"), lambda connection: None)
    address = ("localhost", tcpros_port(node))
    with socket.create_connection(address, 5.0) as bad:
        misbehave(bad)
        time.sleep(0.05)
        with socket.create_connection(address, 5.0) as good:
            good.sendall(tcpros.encode_header({"topic": "/topic"}))
            assert len(good.recv(4)) == 4
    node.close()
    assert capfd.readouterr().err == ""


def test_a_caller_that_hangs_up_is_no_traceback(master, capfd):
    node = tcpros.Node("/node", master)
    answered = threading.Event()

    def answer_late(*_arguments):
        answered.wait(5.0)
        return 1, "", 0

    node._server.register_function(answer_late, "getPid")
    body = xmlrpc.client.dumps(("/other",), "getPid").encode()
    with socket.create_connection(node._server.server_address, 5.0) as caller:
        caller.sendall(b"POST / HTTP/1.1\r\nContent-Length: %d\r\n\r\n" % len(body) + body)
        # An end without ceremony, as of a process that is killed.
        caller.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    answered.set()
    time.sleep(0.1)
    node.close()
    assert capfd.readouterr().err == ""


def test_a_publisher_that_answers_nonsense_is_tried_again_quietly(master, capfd):
    server = xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    calls = []
    server.register_function(lambda *_: calls.append(0) or (0, "busy", 0), "requestTopic")
    threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
    node = tcpros.Node("/node", master)
    node.subscribe("/topic", "std_msgs/Empty", lambda connection: None)
    node.publisherUpdate("/master", "/topic", [f"http://localhost:{server.server_address[1]}"])
    wait_until(lambda: len(calls) >= 2, 5.0, "second try")
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

    wait_until(is_as_before, 5.0, "end of the threads")


@pytest.fixture
def burst_source(monkeypatch):
    """The source of ci/bench, which is not as patient as there."""
    monkeypatch.syspath_prepend(str(peers.SCRIPTS))
    module = importlib.import_module("burst_source")
    monkeypatch.setattr(module, "PATIENCE", 1)
    return module


def test_a_source_waits_for_no_subscriber_without_end(burst_source, master, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["burst_source.py", master, "/topic", "*"])
    monkeypatch.setattr(sys, "stdin", io.StringIO("1000 1\n"))
    with pytest.raises(TimeoutError, match="no subscriber"):
        burst_source.main()


def test_a_source_waits_for_no_stalled_subscriber_without_end(burst_source):
    ours, theirs = socket.socketpair()
    with ours, theirs, pytest.raises(BlockingIOError):
        burst_source.send([ours], 1e6, 60.0)
