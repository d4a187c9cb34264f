"""What a controller has to go through, as data."""

import math
from typing import Dict, NamedTuple, Optional, Sequence, Tuple

from first_order_sys_sim.first_order_plant import PlantSettings
from pid_control.plant.system_parameters import SystemParameters

#: Corners of a signal: (time, s; value), with lines between them; two at one time are a step.
Corners = Sequence[Tuple[float, float]]
#: The course's motor.
MOTOR = SystemParameters().plant
#: Time between two outputs of the motor, and between two set points, s.
STEP_S, SET_POINT_S = 0.002, 0.01
#: Time between two outputs where the loop is slow, s: rospy.Rate makes up for turns that it missed
#: by less than two periods, and at 30 Hz and more it misses more.
SLOW_STEP_S = 0.07

SET_POINT, OUTPUT = "set_point", "motor_output"


class Scenario(NamedTuple):
    """What happens to a controller, in a time that starts at 0.

    :ivar name: one word
    :ivar about: what it is, in a few words
    :ivar duration: how long it lasts, s
    :ivar set_point: the speed that is asked for, rad/s
    :ivar held_speed: the speed, rad/s, of a motor that is held and does not follow its input; none
        where it is free
    :ivar motor: what the motor is like
    :ivar load: what is added to the motor's input
    :ivar noise: standard deviation of what is added to each output, rad/s
    :ivar silence: from when until when the motor says nothing, s
    :ivar restarts: whether the motor begins anew, with time 0 and speed 0, after its silence
    :ivar not_a_number: when NaN comes in place of the next message, s, and on which topic
    :ivar slow_from: from when on the clock and the motor go in steps of SLOW_STEP_S, s
    :ivar standstill_at: when the clock stands still for a while, s
    :ivar events: from when on the controller has to recover from something, s
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
    slow_from: float = math.inf
    standstill_at: float = math.inf
    events: Sequence[float] = ()

    @property
    def suits_any_plant(self) -> bool:
        """Whether it only asks for speeds: it changes neither the motor nor what is heard of it."""
        plain = Scenario(self.name, self.about, self.duration, self.set_point, events=self.events)
        return self == plain


def value_at(corners: Corners, time: float) -> float:
    """Return the value of a signal; before the first corner that one's, after the last that one's.

    :param corners: of the signal, at least one
    :param time: s; at a step the value after it
    """
    before = corners[0]
    for corner in corners:
        if corner[0] > time:
            break
        before = corner
    else:
        return before[1]
    if before[0] > time or corner[0] == before[0]:
        return before[1]
    share = (time - before[0]) / (corner[0] - before[0])
    return before[1] + share * (corner[1] - before[1])


def steps(*corners: Tuple[float, float]) -> Corners:
    """Return a signal that stays at 0, and from each corner on at its value.

    :param corners: time, s, and value
    """
    found = [(0.0, 0.0)]
    for time, value in corners:
        found += [(time, found[-1][1]), (time, value)]
    return tuple(found)


def sine(offset: float, amplitude: float, period: float, begin: float, end: float) -> Corners:
    """Return a signal that is 0 up to a moment, and from then on a sine.

    :param offset: its middle
    :param amplitude: its height above that
    :param period: s
    :param begin: when it begins, s
    :param end: when it ends, s
    """
    count = round((end - begin) / SET_POINT_S)
    moments = [index * SET_POINT_S for index in range(count + 1)]
    wave = [
        (begin + moment, offset + amplitude * math.sin(2.0 * math.pi * moment / period))
        for moment in moments
    ]
    return ((0.0, 0.0), (begin, 0.0), *wave)


#: The motor is held at this speed, and asked for that and a little more, rad/s: the error is known,
#: and so small that the input takes long to its limit.
HELD, LITTLE = 5.0, 0.1
#: When the parts of ``held`` begin, s: more is asked for; the clock stands still; it runs faster.
ASKED_AT, STANDSTILL_AT, FASTER_AT = 0.2, 0.6, 0.8
#: When the loop becomes slow in ``rate``, s.
SLOW_AT = 0.5
#: When the set point is out of reach no longer in ``windup``, s.
BACK_AT = 1.5

SCENARIOS: Tuple[Scenario, ...] = (
    Scenario(
        "held",
        "the motor is held at a speed, and a little more is asked for",
        1.0,
        ((0.0, HELD), (ASKED_AT, HELD), (ASKED_AT, HELD + LITTLE)),
        held_speed=((0.0, HELD), (FASTER_AT, HELD), (FASTER_AT, HELD + 2.0 * LITTLE)),
        standstill_at=STANDSTILL_AT,
    ),
    Scenario(
        "rate",
        "the motor is held, and the loop becomes slow",
        1.5,
        ((0.0, HELD), (0.1, HELD), (0.1, HELD + LITTLE)),
        held_speed=((0.0, HELD),),
        slow_from=SLOW_AT,
    ),
    Scenario(
        "steps",
        "up, further up, down and the other way",
        4.5,
        steps((0.2, 5.0), (1.2, 9.0), (2.2, 3.0), (3.2, -4.0)),
    ),
    Scenario("ramp", "ever faster", 2.0, ((0.0, 0.0), (0.2, 0.0), (2.0, 9.0))),
    Scenario("sine", "to and fro, at 1 Hz", 2.2, sine(5.0, 3.0, 1.0, 0.2, 2.2)),
    Scenario(
        "windup",
        "out of reach, and back",
        3.0,
        steps((0.2, 20.0), (BACK_AT, 5.0)),
        events=(BACK_AT,),
    ),
    Scenario("noise", "a noisy measurement", 1.5, steps((0.2, 5.0)), noise=0.1),
    Scenario(
        "load",
        "something pulls at the motor",
        2.0,
        steps((0.2, 5.0)),
        load=steps((1.0, -0.2)),
        events=(1.0,),
    ),
    Scenario(
        "slower",
        "a motor that is slower than said, and weaker",
        2.2,
        steps((0.2, 5.0), (1.2, 8.0)),
        motor=MOTOR._replace(gain=0.8 * MOTOR.gain, time_constant=2.0 * MOTOR.time_constant),
    ),
    Scenario(
        "faster",
        "a motor that is faster than said, and stronger",
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
        "the motor is started anew",
        2.0,
        steps((0.2, 5.0)),
        silence=(1.0, 1.1),
        restarts=True,
        events=(1.1,),
    ),
    Scenario(
        "early",
        "the controller is there before the motor",
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
