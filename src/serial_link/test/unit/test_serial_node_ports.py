"""Ports of the serial node, by its parameters."""

from typing import Any, List
from unittest import mock

import pytest

from serial_link.hardware.tcp_port import TcpServer
from serial_link.nodes import serial_node
from serial_link.nodes.serial_node import SerialNode
from serial_link.serial_parameters import SerialParameters


def test_each_board_has_a_port_at_the_given_address_and_a_refused_one_is_logged(
    monkeypatch: "pytest.MonkeyPatch", caplog: "pytest.LogCaptureFixture"
) -> None:
    given: List[Any] = []

    class Server(TcpServer):
        def __init__(self, *arguments: Any) -> None:
            given.extend(arguments)
            super().__init__(*arguments)

    monkeypatch.setattr(serial_node, "TcpServer", Server)
    around = mock.Mock()
    around.name = "/serial_node"
    around.declare_parameters.return_value.values = SerialParameters(
        port="tcp", tcp_address="127.0.0.2", tcp_port=11500, tcp_boards="left,right"
    )
    node = SerialNode(around)
    names = [board.link.port_name for board in node._boards]
    assert names == ["tcp 127.0.0.2:11500 left", "tcp 127.0.0.2:11500 right"]
    given[-1]("the board at 10.0.0.1 is refused")
    assert "the board at 10.0.0.1 is refused" in caplog.text
