"""Simulated motor and set point of one scenario, advanced step by step, without ROS."""

import math
import random
from typing import List, NamedTuple, Optional

from first_order_sys_sim.first_order_plant import FirstOrderPlant
from pid_control.judging.record import Row
from pid_control.judging.scenarios import (
    OUTPUT,
    SET_POINT,
    SET_POINT_S,
    SLOW_STEP_S,
    STEP_S,
    Scenario,
    value_at,
)
from pid_control.plant.status import status_of

#: Tolerance of times, which are sums with rounding errors [s].
_EDGE_S = 1e-6


class MotorOutput(NamedTuple):
    """Content of a motor_output message."""

    speed: float
    time: float
    status: str


class OutgoingMessages(NamedTuple):
    """Messages to the controller at one time; None for no message."""

    set_point: Optional[float]
    output: Optional[MotorOutput]


class Experiment:
    """Simulated motor and set point of a scenario; time is an argument.

    Before the scenario begins, while the controller connects, the motor is at rest or held and does
    not follow its input.

    :param scenario: the scenario
    :param clock: time of the clock at the motor's start [s]

    :ivar rows: rows of the scenario so far
    """

    def __init__(self, scenario: Scenario, clock: float) -> None:
        self._scenario = scenario
        self._plant = FirstOrderPlant(scenario.motor)
        self._noise = random.Random(scenario.name)
        self._plant_start, self._set_point_due = clock, clock
        self._zero = math.inf
        self._nan_left = list(scenario.not_a_number)
        self._was_silent = False
        #: The latest finite input.
        self._input = 0.0
        self.rows: List[Row] = []

    @property
    def has_motor(self) -> bool:
        """True if the motor runs before the scenario begins."""
        return self._scenario.silence[0] > 0.0

    def begin_at(self, clock: float) -> None:
        """Begin the scenario.

        :param clock: time of the clock at which the scenario's time is 0 [s]
        """
        self._zero = clock

    def time_at(self, clock: float) -> float:
        """Return the time in the scenario, without the rounding errors of the clock's sum [s].

        :param clock: time of the clock [s]
        """
        return round(clock - self._zero, 9)

    def send(self, clock: float) -> OutgoingMessages:
        """Return the messages that are due.

        :param clock: time of the clock, never decreasing [s]
        """
        scenario, time = self._scenario, self.time_at(clock)
        wanted = value_at(scenario.set_point, time)
        speed = self._record(time, wanted)
        set_point: Optional[float] = None
        if clock >= self._set_point_due - _EDGE_S:
            next_due = self._set_point_due + SET_POINT_S
            self._set_point_due = next_due if next_due > clock else clock + SET_POINT_S
            set_point = math.nan if self._is_nan(SET_POINT, time) else wanted
        begin, end = scenario.silence
        if begin - _EDGE_S <= time < end - _EDGE_S:
            self._was_silent = True
            return OutgoingMessages(set_point, None)
        if self._was_silent and scenario.restarts:
            self._plant_start, self._was_silent = clock, False
        speed += self._noise.gauss(0.0, scenario.noise) if time >= 0.0 else 0.0
        status = status_of(speed, scenario.motor.max_output)
        if self._is_nan(OUTPUT, time):
            speed = math.nan
        return OutgoingMessages(set_point, MotorOutput(speed, clock - self._plant_start, status))

    def step_after(self, clock: float) -> float:
        """Return the time until the next step [s]."""
        begin, end = self._scenario.slow
        is_slow = begin - _EDGE_S <= clock - self._zero < end - _EDGE_S
        return SLOW_STEP_S if is_slow else STEP_S

    def answer(self, clock: float, value: float) -> None:
        """Set the motor's input.

        :param clock: time of the clock [s]
        :param value: the controller's answer; ignored if not finite, as by the motor
        """
        if math.isfinite(value):
            self._input = value
            self._hold(clock - self._zero)

    def _record(self, time: float, wanted: float) -> float:
        """Append a row, and return the motor's speed [rad/s]."""
        scenario = self._scenario
        if scenario.held_speed is not None:
            speed = value_at(scenario.held_speed, time)
        elif time < 0.0:
            speed = 0.0
        else:
            begin, end = scenario.silence
            if scenario.restarts and begin <= time < end:
                self._plant.set_output(time, 0.0)
            speed = self._plant.output(time)
        if time >= 0.0:
            self.rows.append(Row(time, wanted, speed, self._input))
            self._hold(time)
        return speed

    def _hold(self, time: float) -> None:
        if time >= 0.0:
            self._plant.hold(time, self._input + value_at(self._scenario.load, time))

    def _is_nan(self, topic: str, time: float) -> bool:
        """Return True if NaN is due on a topic, once per event."""
        due = [one for one in self._nan_left if one[1] == topic and time >= one[0] - _EDGE_S]
        if due:
            self._nan_left.remove(due[0])
        return bool(due)
