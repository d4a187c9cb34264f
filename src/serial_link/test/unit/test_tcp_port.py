"""A port that boards connect to."""

import os
import pathlib
import socket
import threading
import time

import pytest

from nodekit.testing.processes import free_port
from nodekit.testing.waiting import TIMEOUT_S, wait_until
from serial_link.board.transports import TcpTransport
from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable
from serial_link.hardware.tcp_port import TcpPort, TcpServer
from serial_link.hardware.tcp_slots import parse_slots


def only_port(number: int) -> TcpPort:
    return TcpServer("localhost", number).ports[0]


def test_a_board_connects_and_bytes_go_both_ways() -> None:
    number = free_port()
    port, end = only_port(number), TcpTransport("localhost", number)
    begun = time.monotonic()
    assert not port.open(0.05) and time.monotonic() - begun >= 0.05
    end.plug()
    assert end._socket is not None and port.open(TIMEOUT_S)
    assert end._socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
    assert port.baud == 0 and port.name.startswith(f"tcp localhost:{number} from 127.0.0.1:")
    assert port._board is not None  # small messages do not wait for the acknowledgement of others
    assert port._board.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
    port.write(b"to the board")
    end.wait(TIMEOUT_S)
    assert end.read() == b"to the board" and end.read() == b""
    end.write(b"to the host")
    assert port.read(TIMEOUT_S) == b"to the host" and port.read(0.0) == b""
    end.unplug()
    with pytest.raises(PortLost, match="the connection was closed"):
        port.read(TIMEOUT_S)
    port.close()
    assert port.name == f"tcp localhost:{number}"
    assert port._slot.heard_at is None  # so the board that comes back does not wait
    end.plug()
    assert port.open(TIMEOUT_S)
    port.release()
    wait_until(lambda: end.read() == b"" and not end.is_plugged, lambda: "still connected")
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("localhost", number))


def test_new_connection_replaces_only_a_silent_one(monkeypatch: "pytest.MonkeyPatch") -> None:
    # Longer, so that no connection counts as silent on a slow machine.
    monkeypatch.setattr("serial_link.hardware.tcp_slots.SAME_BOARD_S", TIMEOUT_S)
    number = free_port()
    server = TcpServer("localhost", number)
    port, first, second, third = (
        server.ports[0],
        *(TcpTransport("localhost", number) for _ in "abc"),
    )
    port.open(0.0)
    first.plug()
    assert port.open(TIMEOUT_S)
    second.plug()
    second.write(b"second")
    first.write(b"alive")
    assert port.read(TIMEOUT_S) == b"alive" and port.read(0.1) == b""
    slot = server._slots[0]
    assert slot.connected == "127.0.0.1" and slot.heard_at is not None
    slot.heard_at -= TIMEOUT_S
    port.on_frame()  # so it is not silent
    assert port.read(0.0) == b""
    slot.heard_at -= TIMEOUT_S
    with pytest.raises(
        PortLost, match="^tcp localhost:[^:]*:[0-9]+: replaced by a new connection$"
    ):
        port.read(TIMEOUT_S)
    port.close()
    assert slot.heard_at is not None  # the slot belongs to the second
    assert port.open(TIMEOUT_S)
    wait_until(lambda: first.read() == b"" and not first.is_plugged, lambda: "still connected")
    assert port.read(TIMEOUT_S) == b"second"
    third.plug()
    assert port.read(0.1) == b""  # the second has sent no frame, but is not silent
    port.release()
    second.unplug()
    third.unplug()


@pytest.mark.parametrize("way", ["write", "write_now"])
def test_message_that_a_board_accepts_in_part_ends_the_connection(way: str) -> None:
    number = free_port()
    port, end = only_port(number), TcpTransport("localhost", number)
    port.open(0.0)
    end.plug()
    assert port.open(TIMEOUT_S)
    with pytest.raises(PortStuck, match="has accepted only part of a message within 0.5 s"):
        getattr(port, way)(bytes(3 * 10**7))  # more than the buffers of the system hold
    with pytest.raises(PortLost):
        port.write(b"what would be taken for the rest")
    with pytest.raises(PortLost, match="the connection was closed"):
        port.read(TIMEOUT_S)
    port.release()
    end.unplug()


def test_write_now_does_not_block_while_the_buffer_is_full() -> None:
    number = free_port()
    port, end = only_port(number), TcpTransport("localhost", number)
    with pytest.raises(PortLost, match="is closed"):
        port.write_now(b"x")
    port.open(0.0)
    end.plug()
    assert port.open(TIMEOUT_S)
    assert port.write_now(b"x") and port._board is not None
    with pytest.raises(BlockingIOError):
        while os.write(port._board.fileno(), bytes(10**6)):
            pass
    wait_until(lambda: not port.write_now(b"x"), lambda: "it still takes bytes")
    with pytest.raises(PortStuck, match="has accepted no bytes for 0.5 s"):
        while True:
            port.write(bytes(1000))
    assert port.read(0.0) == b""  # the connection is open
    port.close()
    for write in (port.write, port.write_now):
        with pytest.raises(PortLost, match="is closed"):
            write(b"x")
    port.release()
    end.unplug()


def test_server_listens_on_localhost_by_default() -> None:
    number = free_port()
    port = only_port(number)
    port.open(0.0)
    listening = pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
    places = [line.split()[1] for line in listening if line.split()[3] == "0A"]
    assert f"0100007F:{number:04X}" in places and f"00000000:{number:04X}" not in places
    port.release()


def test_occupied_port_is_reported() -> None:
    with socket.create_server(("localhost", 0)) as taken:
        number = taken.getsockname()[1]
        with pytest.raises(PortUnavailable, match=f"tcp localhost:{number} cannot listen"):
            only_port(number).open(0.0)


def test_boards_have_slots_and_surplus_board_is_refused(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr("serial_link.hardware.tcp_port._SLOT_S", 0.2)
    # All have the same address here: none may replace a silent one on a slow machine.
    monkeypatch.setattr("serial_link.hardware.tcp_slots.SAME_BOARD_S", TIMEOUT_S)
    number, refused = free_port(), []
    server = TcpServer("localhost", number, parse_slots("left,right"), refused.append)
    boards = [TcpTransport("localhost", number) for _ in range(3)]
    assert not server.ports[0].open(0.0)
    for port, board in zip(server.ports, boards):
        board.plug()
        assert port.open(TIMEOUT_S)
        port.on_frame()
    for port, name in zip(server.ports, ("left", "right")):
        assert f"tcp localhost:{number} {name} from 127.0.0.1:" in port.name
        port.write(name.encode())
    boards[2].plug()

    def is_refused() -> bool:
        for port in server.ports:
            assert port.read(0.05) == b""
        return bool(refused)

    wait_until(is_refused, lambda: "not refused")
    assert "the board at 127.0.0.1 is refused: 2 boards are connected already" in refused[0]
    for board, name in zip(boards, (b"left", b"right")):
        board.wait(TIMEOUT_S)
        assert board.read() == name
    wait_until(lambda: boards[2].read() == b"" and not boards[2].is_plugged, lambda: "connected")
    server.ports[0].release()
    socket.create_connection(("localhost", number)).close()  # still listens for the other
    assert server.ports[1].read(0.0) == b""
    server.ports[1].release()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("localhost", number))
    for board in boards:
        board.unplug()


def test_port_probe_takes_no_board_its_namespace() -> None:
    number = free_port()
    server = TcpServer("localhost", number, parse_slots("left,right"))
    left, right = server.ports
    assert not left.open(0.0)
    socket.create_connection(("localhost", number)).close()
    assert left.open(TIMEOUT_S)
    with pytest.raises(PortLost, match="the connection was closed"):
        left.read(TIMEOUT_S)
    left.close()
    boards = [TcpTransport("localhost", number) for _ in "ab"]
    for port, board in zip(server.ports, boards):
        board.plug()
        assert port.open(TIMEOUT_S)
        port.on_frame()
        board.write(port.name.encode())
        assert port.read(TIMEOUT_S) == port.name.encode()
    for port in server.ports:
        port.release()
    for board in boards:
        board.unplug()


def test_reader_waits_while_maximum_of_boards_waits(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr("serial_link.hardware.tcp_slots.SAME_BOARD_S", TIMEOUT_S)
    monkeypatch.setattr("serial_link.hardware.tcp_port._SLOT_S", TIMEOUT_S)
    number = free_port()
    server = TcpServer("localhost", number)
    port = server.ports[0]
    assert not port.open(0.0)
    boards = []
    for _ in range(1 + 16):
        boards.append(socket.create_connection(("localhost", number)))
        assert port._board is not None or port.open(TIMEOUT_S)
        port.read(0.0)
    assert len(server._waiting) == 16
    boards.append(socket.create_connection(("localhost", number)))  # is not accepted yet
    begun = time.monotonic()
    assert port.read(0.2) == b""
    assert time.monotonic() - begun >= 0.2
    for board in boards:
        board.close()
    port.release()


def test_boards_continue_while_refusal_is_logged(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr("serial_link.hardware.tcp_slots.SAME_BOARD_S", TIMEOUT_S)
    monkeypatch.setattr("serial_link.hardware.tcp_port._SLOT_S", 0.0)
    number, went_on = free_port(), []

    def log(_text: str) -> None:
        other = threading.Thread(target=server.listen, daemon=True)
        other.start()
        other.join(TIMEOUT_S)
        went_on.append(not other.is_alive())

    server = TcpServer("localhost", number, on_refused=log)
    port = server.ports[0]
    assert not port.open(0.0)
    boards = [socket.create_connection(("localhost", number)) for _ in "ab"]
    assert port.open(TIMEOUT_S)

    def is_refused() -> bool:
        assert port.read(0.05) == b""
        return bool(went_on)

    wait_until(is_refused, lambda: "not refused")
    assert went_on == [True]
    for board in boards:
        board.close()
    port.release()


def test_rest_of_a_message_that_the_system_accepts_in_part_follows(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    number = free_port()
    port, end = only_port(number), TcpTransport("localhost", number)
    port.open(0.0)
    end.plug()
    assert port.open(TIMEOUT_S)
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, data: write(file, data[:3]))
    assert port.write_now(b"message")
    monkeypatch.undo()
    port.release()
    received = b""
    while end.is_plugged:
        end.wait(TIMEOUT_S)
        received += end.read()
    assert received == b"message"


def test_connection_that_another_thread_closes_meanwhile_is_lost() -> None:
    number = free_port()
    port, end = only_port(number), TcpTransport("localhost", number)
    port.open(0.0)
    end.plug()
    assert port.open(TIMEOUT_S) and port._board is not None
    port._board.close()
    for use in (lambda: port.read(0.0), lambda: port.write(b"x"), lambda: port.write_now(b"x")):
        with pytest.raises(PortLost, match="is gone: "):
            use()
    port.release()
    end.unplug()


def test_board_that_leaves_while_it_waits_is_forgotten() -> None:
    number = free_port()
    server = TcpServer("localhost", number)
    port = server.ports[0]
    assert not port.open(0.0)
    boards = [socket.create_connection(("localhost", number)) for _ in "ab"]
    assert port.open(TIMEOUT_S)
    wait_until(lambda: port.read(0.0) == b"" and server._waiting, lambda: "it does not wait")
    boards[1].close()
    wait_until(lambda: port.read(0.0) == b"" and not server._waiting, lambda: "it waits")
    boards[0].close()
    port.release()
