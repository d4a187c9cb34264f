"""Arguments of the nodes in the launch file; no nodes are started."""

import functools

import pytest
from roslaunch import RLException

from nodekit.testing.launch_files import load_launch, node_names, private_parameters

load = functools.partial(load_launch, "serial_link", "board.launch")


def test_without_hardware_both_nodes_are_at_the_same_port() -> None:
    config = load("port:=/tmp/some", "baud:=9600")
    assert node_names(config) == ["/serial_node", "/simulated_board"]
    link = private_parameters(config, "/serial_node")
    assert link == {
        "port": "/tmp/some",
        "baud": 9600,
        "tcp_port": 11411,
        "tcp_address": "localhost",
        "tcp_boards": "",
    }
    board = private_parameters(config, "/simulated_board")
    assert board == {"link": "/tmp/some", "baud": 9600, "tcp_port": 11411}


def test_avr_board_replaces_python_board() -> None:
    config = load("board:=avr", "port:=/tmp/some")
    assert node_names(config) == ["/avr_board", "/serial_node"]
    assert private_parameters(config, "/avr_board") == {"link": "/tmp/some"}
    with pytest.raises(RLException, match="board is arduino: must be python or avr"):
        load("board:=arduino")
    with pytest.raises(RLException, match="board is avr and simulated is no: must be true"):
        load("board:=avr", "simulated:=no")


def test_with_hardware_the_board_is_the_users() -> None:
    for word in ("off", "0", "False", "no"):
        config = load(f"simulated:={word}", "port:=/dev/ttyUSB0")
        assert node_names(config) == ["/serial_node"]
    for word in ("on", "1", "yes"):
        assert node_names(load(f"simulated:={word}")) == ["/serial_node", "/simulated_board"]
    assert private_parameters(config, "/serial_node")["port"] == "/dev/ttyUSB0"


def test_over_the_network_the_simulated_board_connects() -> None:
    config = load("port:=tcp", "tcp_port:=4000", "tcp_boards:=left,right")
    assert private_parameters(config, "/simulated_board")["link"] == ""
    assert private_parameters(config, "/simulated_board")["tcp_port"] == 4000
    link = private_parameters(config, "/serial_node")
    assert (link["port"], link["tcp_port"], link["tcp_boards"]) == ("tcp", 4000, "left,right")


def test_board_launch_tcp_address_is_the_nodes_own() -> None:
    config = load("port:=tcp", "tcp_address:=0.0.0.0")
    assert private_parameters(config, "/serial_node")["tcp_address"] == "0.0.0.0"
    # The simulated board runs on this machine, and 0.0.0.0 is not an address to connect to.
    assert "tcp_address" not in private_parameters(config, "/simulated_board")
