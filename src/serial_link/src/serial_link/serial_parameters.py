"""Parameters of the serial node."""

import ipaddress

from nodekit import FloatParameter, IntParameter, ParameterSet, StringParameter, read_once, rule
from serial_link.hardware.tcp_slots import parse_slots

#: Value of ``port`` for boards that connect by Wi-Fi.
TCP = "tcp"


class SerialParameters(ParameterSet):
    """Parameters of the serial node; names and defaults are those of rosserial_python."""

    port = read_once(
        StringParameter(
            "/dev/ttyUSB0",
            help="path of the serial port, best below /dev/serial/by-id; tcp for a board that "
            "connects over the network",
        )
    )
    baud = read_once(
        IntParameter(
            57600, minimum=2400, maximum=4000000, unit="Bd", help="baud rate, as in the sketch"
        )
    )
    tcp_port = read_once(
        IntParameter(11411, minimum=1, maximum=65535, help="port that boards connect to, with tcp")
    )
    tcp_address = read_once(
        StringParameter(
            "localhost",
            help="address to listen on, with tcp: localhost for this machine only, 0.0.0.0 for all",
        )
    )
    tcp_boards = read_once(
        StringParameter(
            "",
            help="with tcp, boards at one port: their namespaces by the order in which they first "
            "connect, or by address, as in left,right or left@192.168.1.20; empty for one board",
        )
    )
    service_timeout = FloatParameter(
        5.0, minimum=0.05, maximum=3600.0, unit="s", help="timeout of a service call"
    )

    @rule("tcp_boards", "port")
    def _has_slots(self) -> None:
        try:
            slots = parse_slots(self.tcp_boards)
        except ValueError as error:
            raise ValueError(f"tcp_boards: {error}") from None
        if slots[0].name and self.port != TCP:
            raise ValueError("tcp_boards needs port: tcp; a serial port has one board")

    @rule("tcp_boards", "tcp_address")
    def _can_connect(self) -> None:
        if not _is_this_machine(self.tcp_address):
            return
        for slot in parse_slots(self.tcp_boards):
            if slot.address and not _is_this_machine(slot.address):
                raise ValueError(
                    f"tcp_boards: {slot.name}@{slot.address} cannot connect while tcp_address is "
                    f"{self.tcp_address}, this machine alone: set tcp_address to 0.0.0.0, or to "
                    "this machine's address in that network"
                )

    @rule("port")
    def _has_a_port(self) -> None:
        if not self.port:
            raise ValueError("port must be the path of a serial port, or tcp")


def _is_this_machine(address: str) -> bool:
    """Return whether an address belongs to the loopback interface; False for host names."""
    try:
        return address == "localhost" or ipaddress.IPv4Address(address).is_loopback
    except ValueError:
        return False
