"""Test scenarios of a motor controller, as data: set point, load, noise, NaN, silence, pauses."""

import math
from typing import Dict, NamedTuple, Optional, Sequence, Tuple

from first_order_sys_sim.first_order_plant import PlantSettings
from pid_control.judging import probes
from pid_control.plant.system_parameters import SystemParameters

#: Corners of a piecewise linear signal, (time [s], value); two corners at the same time are a step.
Corners = Sequence[Tuple[float, float]]
#: The course's motor.
MOTOR = SystemParameters().plant
#: Period of the motor's outputs, and of the set points [s].
STEP_S, SET_POINT_S = 0.002, 0.01
#: Period of the outputs while the loop is slow [s]: rospy.Rate catches up on delays shorter than
#: two periods, so a loop with 30 Hz or more is slowed down too.
SLOW_STEP_S = 0.07

SET_POINT, OUTPUT = "set_point", "motor_output"


class Scenario(NamedTuple):
    """A scenario for a controller, in a time that starts at 0.

    :ivar name: one word
    :ivar about: short description
    :ivar duration: duration [s]
    :ivar set_point: set point [rad/s]
    :ivar held_speed: speed of a motor that is held and ignores its input [rad/s]; None if free
    :ivar motor: parameters of the motor
    :ivar load: disturbance, added to the motor's input
    :ivar noise: standard deviation of the measurement noise [rad/s]
    :ivar silence: begin and end of the time without outputs of the motor [s]
    :ivar restarts: True if the motor restarts, with time 0 and speed 0, after its silence
    :ivar not_a_number: times at which the next message is NaN [s], and its topic
    :ivar slow: begin and end of the time in which clock and motor have the period SLOW_STEP_S [s]
    :ivar pauses: times at which the clock is paused [s], each pause longer than the previous
    :ivar events: times from which the controller has to recover from a disturbance [s]
    """

    name: str
    about: str
    duration: float
    set_point: Corners
    held_speed: Optional[Corners] = None
    motor: PlantSettings = MOTOR
    load: Corners = ((0.0, 0.0),)
    noise: float = 0.0
    silence: Tuple[float, float] = (math.inf, math.inf)
    restarts: bool = False
    not_a_number: Sequence[Tuple[float, str]] = ()
    slow: Tuple[float, float] = (math.inf, math.inf)
    pauses: Sequence[float] = ()
    events: Sequence[float] = ()

    @property
    def suits_any_plant(self) -> bool:
        """True if the scenario changes only the set point, not the motor or its messages."""
        plain = Scenario(self.name, self.about, self.duration, self.set_point, events=self.events)
        return self == plain


def value_at(corners: Corners, time: float) -> float:
    """Return the value of a signal, constant before its first and after its last corner.

    :param corners: corners of the signal, at least one
    :param time: time [s]; at a step the value after it
    """
    before = corners[0]
    for corner in corners:
        if corner[0] > time:
            break
        before = corner
    else:
        return before[1]
    if corner[0] == before[0]:
        return before[1]
    share = (time - before[0]) / (corner[0] - before[0])
    return before[1] + share * (corner[1] - before[1])


def steps(*corners: Tuple[float, float]) -> Corners:
    """Return a signal of steps that starts at 0.

    :param corners: time [s] and value of each step
    """
    found = [(0.0, 0.0)]
    for time, value in corners:
        found += [(time, found[-1][1]), (time, value)]
    return tuple(found)


def sine(offset: float, amplitude: float, period: float, begin: float, end: float) -> Corners:
    """Return a signal that is 0 at first, and then a sine.

    :param offset: mean value
    :param amplitude: amplitude
    :param period: period [s]
    :param begin: start of the sine [s]
    :param end: end of the sine [s]
    """
    count = round((end - begin) / SET_POINT_S)
    moments = [index * SET_POINT_S for index in range(count + 1)]
    wave = [
        (begin + moment, offset + amplitude * math.sin(2.0 * math.pi * moment / period))
        for moment in moments
    ]
    return ((0.0, 0.0), (begin, 0.0), *wave)


#: Error that ``rate`` asks for by default [rad/s]; see :func:`scaled`.
LITTLE = 0.1
#: Parts of ``rate`` in which the error is constant: begin, end [s], and its sign. The clock pauses
#: in the first two, and is slow in the next two.
RATE_PARTS = (
    (0.1, 0.5, 1.0),
    (0.5, 0.9, -1.0),
    (0.9, 1.6, 1.0),
    (1.6, 2.3, -1.0),
    (2.3, 2.6, 1.0),
    (2.6, 2.9, -1.0),
)
PAUSES = (0.3, 0.7)
#: Stays out of reach in ``windup``: begin, end [s], and sign; and the end of the way back [s].
STAYS = ((0.2, 1.5, 1.0), (3.0, 3.6, 1.0), (4.8, 6.1, -1.0), (7.6, 8.2, -1.0))
_OUT_OF_REACH, _IN_REACH = 20.0, 5.0
#: Share of the greatest input that ``rate`` asks for.
_SHARE = 0.3
#: Limits of the error that ``rate`` asks for [rad/s].
_LEAST, _LARGEST = 5e-4, 2.0


def _rate(error: float) -> Corners:
    """Return the set point of ``rate``."""
    return steps(*((begin, sign * error) for begin, _, sign in RATE_PARTS))


def _windup() -> Corners:
    """Return the set point of ``windup``."""
    corners = []
    for begin, end, sign in STAYS:
        corners += [(begin, sign * _OUT_OF_REACH), (end, sign * _IN_REACH)]
    return steps(*corners)


def scaled(scenario: Scenario, gain: float, growth: float) -> Scenario:
    """Return a scenario with an error that keeps the controller's input within its limits.

    :param scenario: any scenario; only ``rate`` is changed
    :param gain: the controller's proportional answer to an error [1/(rad/s)]
    :param growth: its integral's answer [1/rad]
    """
    if scenario.name != "rate":
        return scenario
    longest = max(end - begin for begin, end, _ in RATE_PARTS)
    answer = abs(gain) + longest * abs(growth)
    error = min(max(_SHARE / answer, _LEAST), _LARGEST) if answer > 0.0 else LITTLE
    return scenario._replace(set_point=_rate(error))


SCENARIOS: Tuple[Scenario, ...] = (
    Scenario(
        "held",
        "the motor is held; small and large errors of both signs",
        probes.END_AT + 0.1,
        probes.corners(1.0, False),
        held_speed=probes.corners(-1.0, True),
        pauses=(probes.END_AT,),
    ),
    Scenario(
        "rate",
        "the motor is held, the clock pauses, and the loop becomes slow",
        RATE_PARTS[-1][1],
        _rate(LITTLE),
        held_speed=((0.0, 0.0),),
        slow=(RATE_PARTS[2][0], RATE_PARTS[3][1]),
        pauses=PAUSES,
    ),
    Scenario(
        "steps",
        "up, further up, down and the other way",
        4.5,
        steps((0.2, 5.0), (1.2, 9.0), (2.2, 3.0), (3.2, -4.0)),
    ),
    Scenario("ramp", "a ramp", 2.0, ((0.0, 0.0), (0.2, 0.0), (2.0, 9.0))),
    Scenario("sine", "a sine of 1 Hz", 2.2, sine(5.0, 3.0, 1.0, 0.2, 2.2)),
    Scenario(
        "windup",
        "out of reach on either side, and back",
        9.4,
        _windup(),
        events=tuple(end for _, end, _ in STAYS),
    ),
    Scenario("noise", "a noisy measurement", 1.5, steps((0.2, 5.0)), noise=0.1),
    Scenario(
        "load",
        "a load acts on the motor",
        2.0,
        steps((0.2, 5.0)),
        load=steps((1.0, -0.2)),
        events=(1.0,),
    ),
    Scenario(
        "slower",
        "a motor that is slower and weaker than specified",
        2.2,
        steps((0.2, 5.0), (1.2, 8.0)),
        motor=MOTOR._replace(gain=0.8 * MOTOR.gain, time_constant=2.0 * MOTOR.time_constant),
    ),
    Scenario(
        "faster",
        "a motor that is faster and stronger than specified",
        2.2,
        steps((0.2, 5.0), (1.2, 8.0)),
        motor=MOTOR._replace(gain=1.2 * MOTOR.gain, time_constant=0.5 * MOTOR.time_constant),
    ),
    Scenario(
        "missing",
        "no output of the motor for 0.2 s",
        2.0,
        steps((0.2, 5.0), (1.0, 8.0)),
        silence=(1.0, 1.2),
        events=(1.2,),
    ),
    Scenario(
        "restart",
        "the motor is restarted",
        2.0,
        steps((0.2, 5.0)),
        silence=(1.0, 1.1),
        restarts=True,
        events=(1.1,),
    ),
    Scenario(
        "early",
        "the controller starts before the motor",
        1.8,
        ((0.0, 5.0),),
        silence=(-math.inf, 0.6),
        restarts=True,
        events=(0.6,),
    ),
    Scenario(
        "nan",
        "NaN as a measurement, and as a set point",
        2.4,
        steps((0.2, 5.0)),
        not_a_number=((0.9, OUTPUT), (1.5, SET_POINT)),
        events=(0.9, 1.5),
    ),
)
BY_NAME: Dict[str, Scenario] = {scenario.name: scenario for scenario in SCENARIOS}
