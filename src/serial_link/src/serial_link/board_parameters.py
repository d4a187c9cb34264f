"""Parameters of the nodes simulated_board and avr_board."""

from first_order_sys_sim.first_order_plant import PlantSettings
from nodekit import (
    BoolParameter,
    FloatParameter,
    IntParameter,
    ParameterSet,
    StringParameter,
    read_once,
    rule,
)
from serial_link.board.simulation import Faults


class BoardParameters(ParameterSet):
    """Parameters of the board's connection, motor, panel and faults."""

    link = read_once(
        StringParameter(
            "~/.ros/simulated_board",
            help="path of the link to its serial port; empty to connect by TCP",
        )
    )
    tcp_address = read_once(StringParameter("localhost", help="host to connect to by TCP"))
    tcp_port = read_once(
        IntParameter(11411, minimum=1, maximum=65535, help="port to connect to by TCP")
    )
    baud = read_once(
        IntParameter(57600, minimum=0, maximum=4000000, unit="Bd", help="baud rate; 0 for no limit")
    )
    buffer_size = IntParameter(
        512,
        minimum=64,
        maximum=32767,
        unit="B",
        help="size of a message buffer, from the next reset",
    )
    boot_time = FloatParameter(
        0.2, minimum=0.0, maximum=60.0, unit="s", help="time from a reset until the sketch runs"
    )
    rate = FloatParameter(
        100.0, minimum=0.1, maximum=2000.0, unit="Hz", help="rate of motor_output; after a reset"
    )
    gain = FloatParameter(
        13.1, minimum=-1e3, maximum=1e3, unit="rad/s", help="speed at full pulse width"
    )
    time_constant = FloatParameter(
        0.04, above=0.0, maximum=1e3, unit="s", help="time constant of the motor"
    )
    max_speed = FloatParameter(
        13.0, above=0.0, maximum=1e6, unit="rad/s", help="largest magnitude of the speed"
    )
    dead_zone = FloatParameter(
        0.05, minimum=0.0, maximum=1.0, help="dead zone of the driver, as a share of full voltage"
    )
    counts_per_turn = read_once(
        IntParameter(1320, minimum=1, maximum=1000000, help="encoder counts per turn of the shaft")
    )
    button = BoolParameter(False, help="whether the button is pressed")
    potentiometer = FloatParameter(0.5, minimum=0.0, maximum=1.0, help="potentiometer position")
    plugged = BoolParameter(True, help="whether the cable is plugged in")
    noise = FloatParameter(0.0, minimum=0.0, maximum=1.0, help="share of damaged bytes")
    stalled = BoolParameter(False, help="whether the sketch hangs")
    floods = BoolParameter(
        False, help="whether motor_output is sent as fast as the line allows, from the next reset"
    )
    wrong_md5 = StringParameter(
        "", help="topic with a wrong md5sum, from the next reset; empty for none"
    )

    @property
    def plant(self) -> PlantSettings:
        """Settings of the motor."""
        return PlantSettings(self.gain, self.time_constant, self.max_speed, self.dead_zone)

    @property
    def faults(self) -> Faults:
        """Faults of the board and its cable."""
        return Faults(self.noise, self.stalled, self.plugged)


class AvrParameters(ParameterSet):
    """Parameters of a sketch on a simulated Arduino Uno."""

    link = read_once(
        StringParameter("~/.ros/simulated_board", help="path of the link to its serial port")
    )
    sketch = read_once(
        StringParameter(
            "../../docs/examples/board/motor_board/motor_board.ino",
            help="path of the sketch, from the folder of this package",
        )
    )
    packages = read_once(
        StringParameter("pid_control, std_msgs", help="packages whose messages it includes")
    )

    @rule("link")
    def _has_a_port(self) -> None:
        if self.link in ("", "tcp"):
            raise ValueError("link must be a path: this board has only a serial port")
