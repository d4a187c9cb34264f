"""Parameters that a board asks for: the node's own, and those of the master."""

import socket
import time
from types import SimpleNamespace
from typing import Any, List
from unittest import mock

import pytest

from nodekit.master import MISSING, MasterUnreachable
from serial_link.nodes import serial_node
from serial_link.nodes.serial_node import SerialNode
from serial_link.serial_parameters import SerialParameters


def test_only_an_own_parameter_is_not_read_from_the_master(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    def read(names: List[str]) -> Any:
        found = MISSING if names == ["/unset"] else f"{names[0]} of the master"
        return SimpleNamespace(values={names[0]: found})

    client = mock.MagicMock()
    client.return_value.__enter__.return_value.read = read
    monkeypatch.setattr(serial_node, "MasterClient", client)
    around = mock.Mock()
    around.name = "/serial_node"
    around.declare_parameters.return_value.values = SerialParameters(baud=115200)
    node = SerialNode(around)
    assert node._find_parameter("/serial_node/baud") == 115200
    assert node._find_parameter("/unset") is None
    for name in ("/serial_node/gain", "/other/baud", "/baud"):
        assert node._find_parameter(name) == f"{name} of the master"
    monkeypatch.undo()
    with socket.create_server(("localhost", 0)) as hangs:
        monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{hangs.getsockname()[1]}")
        begun = time.monotonic()
        with pytest.raises(MasterUnreachable):
            node._find_parameter("/gain")
    assert time.monotonic() - begun < 4.0  # the board's messages wait meanwhile
