"""Parameters of the link that exclude each other."""

import pytest

from serial_link.serial_parameters import SerialParameters


def test_remote_board_is_rejected_with_local_address() -> None:
    values = {"port": "tcp", "tcp_boards": "left@192.168.1.20,right"}
    for address in ("localhost", "127.0.0.1"):
        with pytest.raises(ValueError, match=r"left@192.168.1.20 cannot .* tcp_address to 0.0.0.0"):
            SerialParameters(tcp_address=address, **values)
    assert SerialParameters(tcp_address="0.0.0.0", **values)
    assert SerialParameters(tcp_address="localhost", port="tcp", tcp_boards="left@127.0.0.2")
