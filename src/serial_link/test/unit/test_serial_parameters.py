"""Parameters of the link: their defaults and limits, and those that exclude each other."""

from typing import Any, Set

import pytest

from serial_link.board_parameters import AvrParameters, BoardParameters
from serial_link.serial_parameters import SerialParameters


def test_remote_board_is_rejected_with_local_address() -> None:
    values = {"port": "tcp", "tcp_boards": "left@127.0.0.2,right@192.168.1.20"}
    for address in ("localhost", "127.0.0.1"):
        why = (
            f"right@192.168.1.20 cannot connect while tcp_address is {address}, this machine alone"
        )
        with pytest.raises(ValueError, match=why + ": set tcp_address to 0.0.0.0"):
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


def test_defaults_are_those_of_rosserial_python() -> None:
    values = SerialParameters()
    assert (values.port, values.baud, values.tcp_port) == ("/dev/ttyUSB0", 57600, 11411)
    assert (values.tcp_address, values.tcp_boards) == ("localhost", "")
    assert values.service_timeout == 5.0


@pytest.mark.parametrize(
    "parameters, names",
    [
        (SerialParameters, {"port", "baud", "tcp_port", "tcp_address", "tcp_boards"}),
        (AvrParameters, {"link", "sketch", "packages"}),
    ],
)
def test_parameters_that_a_running_node_does_not_read_are_marked(
    parameters: Any, names: Set[str]
) -> None:
    assert {name for name, each in parameters.declared.items() if each.read_once} == names


@pytest.mark.parametrize(("name", "most"), [("time_constant", 1e3), ("max_speed", 1e6)])
def test_motor_has_a_time_constant_and_a_largest_speed_above_zero(name: str, most: float) -> None:
    for value in (1e-6, most):
        assert getattr(BoardParameters(**{name: value}), name) == value
    for value in (0.0, most + 1.0):
        with pytest.raises(ValueError, match=f"{name}: refused"):
            BoardParameters(**{name: value})


@pytest.mark.parametrize(
    "parameters, name, least, most, step",
    [
        (SerialParameters, "baud", 2400, 4000000, 1),
        (SerialParameters, "tcp_port", 1, 65535, 1),
        (SerialParameters, "service_timeout", 0.05, 3600.0, 1e-6),
        (BoardParameters, "tcp_port", 1, 65535, 1),
        (BoardParameters, "baud", 0, 4000000, 1),
        (BoardParameters, "buffer_size", 64, 32767, 1),
        (BoardParameters, "boot_time", 0.0, 60.0, 1e-6),
        (BoardParameters, "rate", 0.1, 2000.0, 1e-6),
        (BoardParameters, "gain", -1e3, 1e3, 1e-6),
        (BoardParameters, "dead_zone", 0.0, 1.0, 1e-6),
        (BoardParameters, "counts_per_turn", 1, 1000000, 1),
        (BoardParameters, "potentiometer", 0.0, 1.0, 1e-6),
        (BoardParameters, "noise", 0.0, 1.0, 1e-6),
    ],
)
def test_smallest_and_largest_value_are_taken_and_none_beyond(
    parameters: Any, name: str, least: Any, most: Any, step: Any
) -> None:
    for value in (least, most):
        assert getattr(parameters(**{name: value}), name) == value
    for value in (least - step, most + step):
        with pytest.raises(ValueError, match=f"{name}: refused"):
            parameters(**{name: value})
