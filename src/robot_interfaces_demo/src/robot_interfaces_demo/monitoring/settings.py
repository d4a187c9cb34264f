"""Parameters of fleet_monitor."""

from nodekit import (
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterSet,
    RateParameter,
    StringParameter,
    rule,
)

#: Longest name of a robot, characters.
LONGEST_NAME = 64


def is_name(text: str) -> bool:
    """Return whether a text is a valid name of a robot: short, and printable.

    :param text: the text
    """
    return 0 < len(text) <= LONGEST_NAME and text.isprintable() and text == text.strip()


class FleetMonitorParameters(ParameterSet):
    """Parameters of fleet_monitor."""

    expected = ListParameter(
        [], element=StringParameter("", help="a name"), help="names of robots that must be there"
    )
    period = FloatParameter(
        0.0,
        minimum=0.0,
        maximum=3600.0,
        unit="s",
        help="time between messages of a robot; 0 to learn it, for each robot",
    )
    longest_period = FloatParameter(
        10.0,
        minimum=0.1,
        maximum=3600.0,
        unit="s",
        help="longest period that is learnt; assumed until a robot's period is known",
    )
    stale_after = FloatParameter(
        3.0,
        minimum=1.0,
        maximum=1000.0,
        unit="periods",
        help="time without a message after which a robot is stale",
    )
    lost_after = FloatParameter(
        10.0,
        minimum=1.0,
        maximum=1000.0,
        unit="periods",
        help="time without a message after which a robot is lost",
    )
    battery_low = FloatParameter(
        11.0, minimum=0.0, maximum=1000.0, unit="V", help="warn below this battery voltage"
    )
    temperature_high = FloatParameter(
        40.0, minimum=-100.0, maximum=1000.0, unit="°C", help="warn above this temperature"
    )
    obstacle_near = FloatParameter(
        0.3, minimum=0.0, maximum=1000.0, unit="m", help="warn of obstacles nearer than this"
    )
    hysteresis = FloatParameter(
        0.02,
        minimum=0.0,
        maximum=0.5,
        help="fraction of a limit by which a reading must come back to end its warning",
    )
    max_robots = IntParameter(
        1000, minimum=1, maximum=100000, help="most robots, besides the expected ones"
    )
    forget_after = FloatParameter(
        3600.0,
        minimum=1.0,
        maximum=1e9,
        unit="s",
        help="time without a message after which an unexpected lost robot is removed",
    )
    rate = RateParameter(
        1.0, maximum=50.0, help="how often diagnostics are published and changes logged"
    )

    @rule("stale_after", "lost_after")
    def _stale_before_lost(self) -> None:
        if self.stale_after > self.lost_after:
            raise ValueError("stale_after must be at most lost_after")

    @rule("expected")
    def _expected_are_names(self) -> None:
        if not all(map(is_name, self.expected)):
            text = f"each must be text of 1 to {LONGEST_NAME} printable characters"
            raise ValueError(f"{text}, with no space around it")
