"""Tests of the TCPROS server, with fake handlers."""

import contextlib
import errno
import io
import itertools
import socket
import struct
import threading
import time

import pytest
import rospy
from rosgraph.network import encode_ros_handshake_header, read_ros_handshake_header
from rospy.impl.tcpros_base import TCPROSServer, TCPServer

from nodekit.rospy_internals import tcpros_server
from nodekit.testing.waiting import wait_until

TIME_OUT = 20.0  # s


class Served:
    """A server of rospy's that notes who wants what, and does as little as a handler may."""

    def __init__(self, stack, ended):
        self.ended = ended
        self.heard = []
        self.taken = []
        self.server = TCPROSServer()
        self.server.topic_connection_handler = self.take_topic
        self.server.service_connection_handler = self.take_service
        self.server.start_server()
        self.stack = stack
        stack.callback(self.end)

    def take_topic(self, sock, address, header):
        assert sock.gettimeout() is None, "rospy's handlers expect a socket that blocks"
        if header["topic"] == "/defect":
            raise KeyError("defect")
        if header["topic"] != "/topic":
            return "no such topic"
        sock.settimeout(TIME_OUT)
        self.taken.append(sock)
        self.heard.append(header["callerid"])

    def take_service(self, sock, address, header):
        self.take_topic(sock, address, {"topic": "/topic", "callerid": header["service"]})

    def connect(self):
        peer = socket.create_connection(("localhost", self.server.get_address()[1]), TIME_OUT)
        return self.stack.enter_context(peer)

    def ask(self, **fields):
        peer = self.connect()
        peer.sendall(header(**fields))
        return peer

    def wait_for(self, *names):
        wait_until(lambda: self.heard == list(names), lambda: str(self.heard))

    def end(self):
        for sock in self.taken:
            sock.close()
        self.server.tcp_ros_server.is_shutdown = True
        self.connect()  # closing alone would not end the thread's wait
        assert self.ended.wait(TIME_OUT)
        self.server.tcp_ros_server.server_sock.close()


def header(**fields):
    return encode_ros_handshake_header({"topic": "/topic", "callerid": "/n", **fields})


def is_closed(peer):
    """Wait for the other side to close; return whether it did."""
    try:
        return peer.recv(1) == b""
    except ConnectionResetError:
        return True


def is_open(peer):
    """Tell whether the other side has not hung up."""
    peer.settimeout(0.05)
    try:
        return peer.recv(1) != b""
    except socket.timeout:
        return True
    finally:
        peer.settimeout(TIME_OUT)


@pytest.fixture
def warnings(monkeypatch):
    texts = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: texts.append(text % values))
    return texts


@pytest.fixture
def served(monkeypatch, warnings):
    monkeypatch.setattr(TCPServer, "run", TCPServer.run)
    tcpros_server.patch_tcpros_server()
    run, ended = TCPServer.run, threading.Event()
    monkeypatch.setattr(TCPServer, "run", lambda server: (run(server), ended.set()))
    with contextlib.ExitStack() as stack:
        yield Served(stack, ended)


def test_this_rospy_is_known():
    assert tcpros_server.tcpros_server_mismatch() == ""


@pytest.mark.parametrize("method", ["_RUN", "_START", "_HANDLE"])
@pytest.mark.parametrize("other", [lambda server: None, print])
def test_different_rospy_server_is_left_alone(monkeypatch, warnings, method, other):
    monkeypatch.setattr(tcpros_server, method, other)
    run = TCPServer.run
    tcpros_server.patch_tcpros_server()
    assert TCPServer.run is run
    assert "unsupported rospy version" in warnings[0]


def test_silent_connections_delay_no_other(served):
    served.connect()
    served.connect().sendall(header()[:7])
    served.ask(callerid="/subscriber")
    served.connect().sendall(encode_ros_handshake_header({"service": "/client"}))
    served.wait_for("/subscriber", "/client")


def test_header_in_pieces_is_assembled_and_later_bytes_are_left(served):
    peer = served.connect()
    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    for byte in header(callerid="/slow"):
        peer.sendall(bytes([byte]))
    peer.sendall(b"behind")
    served.wait_for("/slow")
    assert served.taken[0].recv(6) == b"behind"


def test_bytes_after_a_header_are_left(served):
    served.connect().sendall(header(callerid="/quick") + b"behind")
    served.wait_for("/quick")
    assert served.taken[0].recv(100) == b"behind"


def test_headers_are_handled_in_the_order_of_arrival(served):
    """Test that the later of two connections under one name is handled last, which rospy keeps."""
    hold, held = threading.Event(), threading.Event()

    def wait(sock, address, header):
        served.taken.append(sock)
        held.set()
        hold.wait(TIME_OUT)

    served.server.topic_connection_handler = wait
    peers = [served.connect() for _ in range(10)]
    served.ask()
    assert held.wait(TIME_OUT)
    served.server.topic_connection_handler = served.take_topic
    names = [f"/{number}" for number in range(len(peers))]
    for peer, name in reversed(list(zip(peers, names))):  # which is not the order of arrival
        peer.sendall(header(callerid=name))
    hold.set()
    served.wait_for(*names)


@pytest.mark.parametrize("drip", [b"", b"x"])
def test_slow_header_is_closed(monkeypatch, served, warnings, drip):
    monkeypatch.setattr(tcpros_server, "HEADER_TIMEOUT_S", 0.3)
    peer = served.connect()
    peer.sendall(struct.pack("<I", 1000))
    before = time.monotonic()
    peer.settimeout(0.02)
    for _ in itertools.count():
        try:
            peer.sendall(drip)
            assert peer.recv(1) == b""
            break
        except socket.timeout:
            assert time.monotonic() - before < TIME_OUT
        except ConnectionError:
            break
    served.ask(callerid="/later")
    served.wait_for("/later")
    assert "no complete header within 0.3 s" in warnings[0]


def test_of_too_many_silent_connections_the_oldest_go(monkeypatch, served, warnings):
    monkeypatch.setattr(tcpros_server, "MOST_WAITING", 3)
    monkeypatch.setattr(tcpros_server, "GRACE_S", 0.1)
    peers = [served.connect() for _ in range(4)]
    assert is_closed(peers[0])
    served.ask(callerid="/newcomer")
    served.wait_for("/newcomer")
    assert is_open(peers[3])
    assert "it sent no complete header within" in warnings[0]
    peers[3].sendall(header(callerid="/patient"))
    served.wait_for("/newcomer", "/patient")


def test_many_simultaneous_connections_cut_no_other_off(monkeypatch, served, warnings):
    monkeypatch.setattr(tcpros_server, "MOST_WAITING", 3)
    monkeypatch.setattr(tcpros_server, "GRACE_S", TIME_OUT)
    peers = [served.connect() for _ in range(3)]
    peers.append(served.ask(callerid="/3"))
    time.sleep(0.05)
    assert served.heard == [], "there are as many as may be already"
    for number, peer in enumerate(peers[:3]):
        peer.sendall(header(callerid=f"/{number}"))
    wait_until(lambda: sorted(served.heard) == ["/0", "/1", "/2", "/3"], lambda: str(served.heard))
    assert warnings == []


def test_more_clients_than_rospys_queue_holds_connect_simultaneously(monkeypatch, served, warnings):
    served.ask()
    served.wait_for("/n")  # it accepts
    monkeypatch.setattr(tcpros_server, "MOST_WAITING", 3)
    port = served.server.get_address()[1]
    # All but three stay in the queue. Who finds it full tries again after 1 s.
    peers = [socket.create_connection(("localhost", port), 0.9) for _ in range(30)]
    for peer in peers:
        peer.close()


def test_too_long_a_header_is_refused_before_it_is_read(served, warnings):
    peer = served.connect()
    peer.sendall(struct.pack("<I", 2**32 - 1))
    assert is_closed(peer)
    (text,) = wait_until(lambda: warnings, lambda: "no warning")
    assert "its header of 4294967295 bytes is longer than the limit of 1000000" in text


def test_longest_header_is_read(monkeypatch, served):
    whole = header(callerid="/long", message_definition="x" * 100_000)
    monkeypatch.setattr(tcpros_server, "LONGEST_HEADER", len(whole) - 4)
    served.connect().sendall(whole)
    served.wait_for("/long")


@pytest.mark.parametrize(
    "said, answer",
    [
        (header(topic="/other"), "no such topic"),
        (encode_ros_handshake_header({"callerid": "/n"}), "no topic or service name detected"),
        (struct.pack("<I", 0), "no topic or service name detected"),
    ],
)
def test_invalid_request_is_answered_by_an_error(served, warnings, said, answer):
    peer = served.connect()
    peer.sendall(said)
    with contextlib.closing(peer.makefile("rb")) as stream:
        (size,) = struct.unpack("<I", stream.read(4))
        assert stream.read(size)[4:].decode() == "error=" + answer
        assert stream.read() == b""
    (text,) = wait_until(lambda: warnings, lambda: "no warning")
    assert answer in text


@pytest.mark.parametrize("said", [header(topic="/defect"), header()[:9], struct.pack("<II", 8, 9)])
def test_garbage_and_exceptions_end_one_connection_only(served, warnings, said):
    waiting = served.connect()
    peer = served.connect()
    peer.sendall(said)
    peer.shutdown(socket.SHUT_WR)
    assert is_closed(peer)
    waiting.sendall(header(callerid="/other"))
    served.wait_for("/other")
    assert len(warnings) == 1


@pytest.mark.parametrize("number", [errno.EMFILE, errno.EPROTO, errno.EPERM])
def test_accepting_continues_after_a_failed_accept(monkeypatch, served, warnings, number):
    """Rospy's own thread ends with this error, and no client can connect after that."""
    monkeypatch.setattr(tcpros_server, "_PAUSE_S", 0.01)
    accept = socket.socket.accept
    errors = [OSError(number, "no room"), ConnectionAbortedError(), BlockingIOError()]

    def fail_first(sock):
        if errors:
            raise errors.pop(0)
        return accept(sock)

    monkeypatch.setattr(socket.socket, "accept", fail_first)
    served.ask(callerid="/subscriber")
    served.wait_for("/subscriber")
    assert ["no room" in text for text in warnings] == [True]


def test_server_that_is_shut_down_before_it_runs_ends_without_a_word(served):
    server = TCPServer(None)
    server.shutdown()
    server.run()


def test_header_is_read_as_by_rospy():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(header(callerid="/same"))
        pending = tcpros_server._Pending(ours, ("127.0.0.1", 1))
        read = pending.read_header()
        theirs.sendall(header(callerid="/same"))
        ours.setblocking(True)
        assert read == read_ros_handshake_header(ours, io.BytesIO(), 4096)
