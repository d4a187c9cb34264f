"""Parameters of the link to a board."""

from nodekit import FloatParameter, IntParameter, ParameterSet, StringParameter, read_once, rule
from serial_link.hardware.tcp_seats import parse_seats

#: The name of a port that boards with Wi-Fi connect to.
TCP = "tcp"


class SerialParameters(ParameterSet):
    """Parameters of the link; names and defaults are those of rosserial_python."""

    port = read_once(
        StringParameter(
            "/dev/ttyUSB0",
            help="path of the serial port, best below /dev/serial/by-id; tcp for a board that "
            "connects over the network",
        )
    )
    baud = read_once(
        IntParameter(
            57600, minimum=2400, maximum=4000000, unit="Bd", help="bits a second, as in the sketch"
        )
    )
    tcp_port = read_once(
        IntParameter(11411, minimum=1, maximum=65535, help="where boards connect to, with tcp")
    )
    tcp_address = read_once(
        StringParameter(
            "localhost",
            help="who may connect, with tcp: localhost for this machine, 0.0.0.0 for everybody",
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
        5.0, minimum=0.05, maximum=3600.0, unit="s", help="longest wait for a service's answer"
    )

    @rule("tcp_boards", "port")
    def _has_seats(self) -> None:
        try:
            seats = parse_seats(self.tcp_boards)
        except ValueError as error:
            raise ValueError(f"tcp_boards: {error}") from None
        if seats[0].name and self.port != TCP:
            raise ValueError("tcp_boards needs port: tcp; a serial port has one board")

    @rule("port")
    def _has_a_port(self) -> None:
        if not self.port:
            raise ValueError("port must be the path of a serial port, or tcp")
