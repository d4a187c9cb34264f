"""Problems of a robot, found in its messages."""

import enum
import math
from typing import FrozenSet, Iterator, NamedTuple, Sequence

from nodekit import to_float32
from robot_interfaces_demo.modes import KNOWN, Mode
from robot_interfaces_demo.monitoring.settings import FleetMonitorParameters

#: Number of readings in a complete message.
READINGS = 3


class Level(enum.IntEnum):
    """Severity, with the numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


class Problem(enum.Enum):
    """Problem of a robot: severity and text."""

    TWO_PUBLISHERS = (Level.ERROR, "several nodes publish under this name")
    ERROR_MODE = (Level.ERROR, "error mode")
    UNKNOWN_MODE = (Level.WARN, "unknown mode")
    SHORT = (Level.WARN, "readings are missing")
    NOT_FINITE = (Level.WARN, "a reading is not finite")
    LOW_BATTERY = (Level.WARN, "battery is low")
    HOT = (Level.WARN, "too hot")
    NEAR_OBSTACLE = (Level.WARN, "obstacle is near")

    @property
    def level(self) -> Level:
        """Severity."""
        return self.value[0]

    @property
    def text(self) -> str:
        """Text for users."""
        return self.value[1]


#: Defects of a message; only the first of each kind is logged.
DEFECTS = frozenset((Problem.UNKNOWN_MODE, Problem.SHORT, Problem.NOT_FINITE))


class Limit(NamedTuple):
    """A reading and its limit.

    :param problem: raised when the limit is exceeded
    :param name: of the reading
    :param unit: its unit
    :param parameter: name of the parameter with the limit
    :param sign: 1.0 for an upper limit, -1.0 for a lower limit
    """

    problem: Problem
    name: str
    unit: str
    parameter: str
    sign: float


#: Readings in the order of the message.
LIMITS = (
    Limit(Problem.LOW_BATTERY, "battery", "V", "battery_low", -1.0),
    Limit(Problem.HOT, "temperature", "°C", "temperature_high", 1.0),
    Limit(Problem.NEAR_OBSTACLE, "obstacle", "m", "obstacle_near", -1.0),
)


def find_problems(
    mode: int,
    readings: Sequence[float],
    before: FrozenSet[Problem],
    settings: FleetMonitorParameters,
) -> FrozenSet[Problem]:
    """Return the problems in a message.

    :param mode: number of the mode
    :param readings: as in the message; those beyond the third are ignored
    :param before: previous problems, for the hysteresis; a reading that is missing or not finite
        keeps its own problem
    :param settings: the limits
    """
    return frozenset(_wrong(mode, readings, before, settings))


def _wrong(
    mode: int,
    readings: Sequence[float],
    before: FrozenSet[Problem],
    settings: FleetMonitorParameters,
) -> Iterator[Problem]:
    if mode == Mode.ERROR:
        yield Problem.ERROR_MODE
    elif mode not in KNOWN:
        yield Problem.UNKNOWN_MODE
    if len(readings) < READINGS:
        yield Problem.SHORT
    for index, (problem, _, _, parameter, sign) in enumerate(LIMITS):
        reading = readings[index] if index < len(readings) else None
        if reading is None or not math.isfinite(reading):
            if reading is not None:
                yield Problem.NOT_FINITE
            if problem in before:
                yield problem
            continue
        limit = to_float32(getattr(settings, parameter))  # like readings
        margin = abs(limit) * settings.hysteresis if problem in before else 0.0
        if sign * (reading - limit) > -margin:
            yield problem
