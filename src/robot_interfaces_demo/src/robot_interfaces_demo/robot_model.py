# Pure: knows no ROS.
"""Simulated robot that drains its battery, warms up and passes obstacles, and its faults."""

import math
from typing import Callable, Dict, List, NamedTuple

from robot_interfaces_demo.modes import Mode

#: Change per message, and bounds: battery [V] and temperature [degC].
_CHARGE_V, _FULL_V = 0.03, 12.6
_DRAIN_V, _EMPTY_V = 0.005, 10.0
_WARM_UP_C, _HOTTEST_C = 0.1, 45.0
_COOL_DOWN_C, _COOLEST_C = 0.05, 20.0
#: Nearest obstacle: mean distance [m], amplitude [m], and messages per cycle.
_DISTANCE_M, _SWING_M, _TURN = 2.0, 1.5, 40


class Status(NamedTuple):
    """Status that a robot publishes.

    :param mode: number of its mode
    :param readings: battery [V]; temperature [degC]; nearest obstacle [m]
    """

    mode: int
    readings: List[float]


class RobotModel:
    """Robot that cycles through all modes."""

    def __init__(self) -> None:
        self._count = 0
        self._mode = Mode.IDLE
        self._battery_v, self._temperature_c = 12.5, 25.0

    def step(self, messages_per_mode: int) -> Status:
        """Return the next status.

        :param messages_per_mode: number of messages in each mode
        """
        self._count += 1
        if self._count % messages_per_mode == 0:
            self._mode = Mode((self._mode + 1) % len(Mode))
        if self._mode == Mode.CHARGING:
            self._battery_v = min(self._battery_v + _CHARGE_V, _FULL_V)
        else:
            self._battery_v = max(self._battery_v - _DRAIN_V, _EMPTY_V)
        if self._mode in (Mode.MOVING, Mode.WORKING):
            self._temperature_c = min(self._temperature_c + _WARM_UP_C, _HOTTEST_C)
        else:
            self._temperature_c = max(self._temperature_c - _COOL_DOWN_C, _COOLEST_C)
        obstacle = _DISTANCE_M + _SWING_M * math.cos(math.tau * self._count / _TURN)
        return Status(int(self._mode), [self._battery_v, self._temperature_c, obstacle])


def _with_reading(index: int, value: float) -> Callable[[Status], Status]:
    def change(status: Status) -> Status:
        readings = list(status.readings)
        readings[index] = value
        return status._replace(readings=readings)

    return change


#: Faults of a robot, each with its effect on the status.
FAULTS: Dict[str, Callable[[Status], Status]] = {
    "none": lambda status: status,
    "low_battery": _with_reading(0, 10.5),
    "hot": _with_reading(1, 55.0),
    "near_obstacle": _with_reading(2, 0.1),
    "not_finite": _with_reading(1, math.nan),
    "short": lambda status: status._replace(readings=status.readings[:1]),
    "unknown_mode": lambda status: status._replace(mode=99),
}
