"""Parameters of the link that exclude each other."""

from typing import Any

import pytest

from serial_link.serial_parameters import SerialParameters


def test_remote_board_is_rejected_with_local_address() -> None:
    values = {"port": "tcp", "tcp_boards": "left@127.0.0.2,right@192.168.1.20"}
    for address in ("localhost", "127.0.0.1"):
        with pytest.raises(ValueError, match="right@192.168.1.20 cannot .* set tcp_address to"):
            SerialParameters(tcp_address=address, **values)
    assert SerialParameters(tcp_address="0.0.0.0", **values)
    assert SerialParameters(tcp_address="localhost", port="tcp", tcp_boards="left@127.0.0.2")


@pytest.mark.parametrize(
    "values, why",
    [
        ({"port": ""}, "port must be the path of a serial port, or tcp"),
        ({"tcp_boards": "left"}, "tcp_boards needs port: tcp; a serial port has one board"),
        ({"port": "tcp", "tcp_boards": "le-ft"}, "tcp_boards: 'le-ft' is not a namespace"),
    ],
)
def test_invalid_port_or_list_of_boards_is_rejected(values: Any, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        SerialParameters(**values)
