"""Tests of a service call over TCP, with a fake server."""

import contextlib
import socket
import struct
import threading
import time
from typing import Iterator, List, Optional, Tuple

import pytest

from nodekit.testing.waiting import TIMEOUT_S
from nodekit.transport.service_call import CallFailed, ServiceCall

HEADER = {"callerid": "/test", "service": "/add", "md5sum": "*"}


def block(content: bytes) -> bytes:
    """Return something with its length before it."""
    return struct.pack("<I", len(content)) + content


GREETING = block(block(b"callerid=/server") + block(b"type=a=b"))


class Server:
    """Accepts one connection, sends one answer, and records the received data.

    :param answer: all that it sends
    :param hangs_up: whether it closes the connection after that
    :param pause: pause after each byte of the answer [s]; 0 to send all together

    :ivar sent: how much of it was sent so, bytes
    """

    def __init__(self, answer: bytes, hangs_up: bool = False, pause: float = 0.0) -> None:
        self.received, self.sent = b"", 0
        self.hung_up = threading.Event()
        self._answer, self._hangs_up, self._pause = answer, hangs_up, pause
        self._socket = socket.socket()
        self._socket.bind(("localhost", 0))
        self._socket.listen(1)
        threading.Thread(target=self._serve, daemon=True).start()

    @property
    def address(self) -> Tuple[str, int]:
        return "localhost", self._socket.getsockname()[1]

    def _serve(self) -> None:
        connection, _ = self._socket.accept()
        with connection:
            with contextlib.suppress(OSError):
                self._send_answer(connection)
                if self._hangs_up:
                    connection.shutdown(socket.SHUT_WR)
                for part in iter(lambda: connection.recv(4096), b""):
                    self.received += part
            self.hung_up.set()

    def _send_answer(self, connection: socket.socket) -> None:
        if not self._pause:
            connection.sendall(self._answer)
            return
        for self.sent in range(len(self._answer)):
            connection.sendall(self._answer[self.sent :][:1])
            time.sleep(self._pause)

    def close(self) -> None:
        self._socket.close()


@contextlib.contextmanager
def serving(answer: bytes, hangs_up: bool = False, pause: float = 0.0) -> Iterator[Server]:
    server = Server(answer, hangs_up, pause)
    with contextlib.closing(server):
        yield server


def call(server: Server, request: Optional[bytes] = b"12", timeout: float = TIMEOUT_S) -> bytes:
    return ServiceCall(timeout).run(server.address, HEADER, request)


@pytest.mark.parametrize("size", [0, 3, 3 << 20])
def test_answer_of_any_size(size: int) -> None:
    body = bytes(number % 251 for number in range(size))
    with serving(GREETING + b"\1" + block(body)) as server:
        assert call(server) == body
        assert server.hung_up.wait(TIMEOUT_S)
    sent = block(b"".join(block(f"{name}={value}".encode()) for name, value in HEADER.items()))
    assert server.received == sent + block(b"12")


def test_server_header_describes_the_service() -> None:
    look = ServiceCall(TIMEOUT_S)
    assert look.said == {}
    with serving(GREETING) as server:
        look.run(server.address, HEADER, None)
    assert look.said == {"callerid": "/server", "type": "a=b"}


def test_a_look_sends_no_request() -> None:
    with serving(GREETING) as server:
        assert call(server, None) == b""
        assert server.hung_up.wait(TIMEOUT_S)
    assert server.received.endswith(b"md5sum=*")


@pytest.mark.parametrize(
    "answer, reason",
    [
        (GREETING + b"\0" + block(b"a is no number"), "a is no number"),
        (block(block(b"error=no such service")), "no such service"),
        (struct.pack("<I", 1 << 30), "a header of 1073741824 bytes: not a ROS service"),
        (struct.pack("<I", (64 << 10) + 1), "a header of 65537 bytes: not a ROS service"),
    ],
)
def test_refusal_is_reported(answer: bytes, reason: str) -> None:
    with serving(answer) as server, pytest.raises(CallFailed, match=reason):
        call(server)


@pytest.mark.parametrize("answer", [b"", b"\3", GREETING, GREETING + b"\1" + block(b"12")[:-1]])
def test_server_that_hangs_up(answer: bytes) -> None:
    with serving(answer, hangs_up=True) as server, pytest.raises(ConnectionError, match="hung up"):
        call(server)


@pytest.mark.parametrize("answer", [b"", b"\3", GREETING, GREETING + b"\1" + block(b"12")[:-1]])
def test_server_that_hangs_costs_the_time_out(answer: bytes) -> None:
    with serving(answer) as server:
        began = time.monotonic()
        with pytest.raises(socket.timeout):
            call(server, timeout=0.05)
        assert 0.05 <= time.monotonic() - began < TIMEOUT_S / 2
        assert server.hung_up.wait(TIMEOUT_S)


@pytest.mark.parametrize("begun", [b"", GREETING + b"\1"])
def test_server_that_sends_a_byte_now_and_then_costs_the_time_out_too(begun: bytes) -> None:
    answer = begun + block(b"name=" + bytes(1000))  # takes 20 s
    with serving(answer, hangs_up=True, pause=0.02) as server:
        with pytest.raises(socket.timeout):
            call(server, timeout=0.3 + 0.02 * len(begun))
        assert server.hung_up.wait(TIMEOUT_S)
        assert server.sent < len(answer) / 2


def test_longest_header_is_read() -> None:
    field = b"name=" + bytes((64 << 10) - 9)
    with serving(block(block(field)) + b"\1" + block(b"3")) as server:
        assert call(server) == b"3"


def test_header_without_sense_is_a_header_without_fields() -> None:
    with serving(block(b"\xff\xff") + b"\1" + block(b"3")) as server:
        assert call(server) == b"3"


def test_call_is_cancelled_before_and_while_running() -> None:
    errors: List[Exception] = []

    def run(under_way: ServiceCall, server: Server) -> None:
        try:
            under_way.run(server.address, HEADER, b"12")
        except OSError as error:
            errors.append(error)

    for is_early in (False, True):
        with serving(GREETING) as server:
            under_way = ServiceCall(TIMEOUT_S)
            if is_early:
                under_way.cancel()
            thread = threading.Thread(target=run, args=(under_way, server), daemon=True)
            thread.start()
            if not is_early:
                while not server.received.endswith(b"12"):
                    time.sleep(0.001)
                under_way.cancel()
            thread.join(TIMEOUT_S)
            assert not thread.is_alive()
            assert server.hung_up.wait(TIMEOUT_S)
    assert len(errors) == 2 and not isinstance(errors[0], socket.timeout)
    assert str(errors[1]) == "cancelled"


def test_time_left_counts_from_the_call_s_making() -> None:
    assert 0.0 < ServiceCall(TIMEOUT_S).left() <= TIMEOUT_S
    late = ServiceCall(0.001)
    time.sleep(0.002)
    with serving(GREETING) as server, pytest.raises(socket.timeout):
        late.run(server.address, HEADER, b"12")
