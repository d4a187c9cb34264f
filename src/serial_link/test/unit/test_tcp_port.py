"""A port that boards connect to."""

import pathlib
import socket

import pytest

from nodekit.testing.processes import free_port
from nodekit.testing.waiting import wait_until
from serial_link.board.transports import TcpTransport
from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable
from serial_link.hardware.tcp_port import TcpPort


def test_a_board_connects_and_bytes_go_both_ways() -> None:
    number = free_port()
    port, end = TcpPort("localhost", number), TcpTransport("localhost", number)
    assert not port.open(0.0)
    end.plug()
    assert end.is_plugged and port.open(5.0)
    assert port.baud == 0 and port.name.startswith(f"tcp localhost:{number} from 127.0.0.1:")
    port.write(b"to the board")
    end.wait(5.0)
    assert end.read() == b"to the board" and end.read() == b""
    end.write(b"to the host")
    assert port.read(5.0) == b"to the host" and port.read(0.0) == b""
    end.unplug()
    with pytest.raises(PortLost, match="the connection was closed"):
        port.read(5.0)
    port.release()


def test_a_board_that_connects_anew_replaces_the_one_before() -> None:
    number = free_port()
    port, first, second = (
        TcpPort("localhost", number),
        *(TcpTransport("localhost", number) for _ in "ab"),
    )
    port.open(0.0)
    first.plug()
    assert port.open(5.0)
    second.plug()
    with pytest.raises(PortLost, match="another board has connected"):
        port.read(5.0)
    port.close()
    assert port.open(5.0)
    wait_until(lambda: first.read() == b"" and not first.is_plugged, lambda: "still connected")
    second.write(b"second")
    assert port.read(5.0) == b"second"
    port.release()
    second.unplug()


def test_a_message_that_a_board_takes_in_part_ends_the_connection() -> None:
    number = free_port()
    port, end = TcpPort("localhost", number), TcpTransport("localhost", number)
    port.open(0.0)
    end.plug()
    assert port.open(5.0)
    with pytest.raises(PortStuck, match="takes no more of a message for 0.5 s"):
        port.write(bytes(3 * 10**7))  # more than the buffers of the system hold
    with pytest.raises(PortLost):
        port.write(b"what would be taken for the rest")
    with pytest.raises(PortLost, match="the connection was closed"):
        port.read(5.0)
    port.release()
    end.unplug()


def test_it_listens_on_this_machine_alone_unless_told_otherwise() -> None:
    number = free_port()
    port = TcpPort("localhost", number)
    port.open(0.0)
    listening = pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
    places = [line.split()[1] for line in listening if line.split()[3] == "0A"]
    assert f"0100007F:{number:04X}" in places and f"00000000:{number:04X}" not in places
    port.release()


def test_a_port_that_is_taken_is_told() -> None:
    with socket.create_server(("localhost", 0)) as taken:
        number = taken.getsockname()[1]
        with pytest.raises(PortUnavailable, match=f"tcp localhost:{number} cannot be listened on"):
            TcpPort("localhost", number).open(0.0)
