"""A PID controller whose output is limited: proportional, integral, derivative, feed-forward.

In continuous time, with set point r, measurement y and unlimited output v::

    v = kp (b r - y) + ki integral(r - y) - kd dy/dt / (1 + tf d/dt) + kf r

(Åström, Murray: Feedback Systems, 2nd edition, section 11.1 and, for the weight b and the filtered
derivative of the measurement, 11.5.) It is computed at each measurement, a time dt after the last
one, by backward differences (ibid., 11.5, "Implementation")::

    I[n] = I[n-1] + ki dt (r - y[n])
    D[n] = (tf D[n-1] - kd (y[n] - y[n-1])) / (tf + dt)

which are stable for any dt. What a limited output cannot do must not be integrated: the integral
would go on growing, and the output would leave its limit late (windup, ibid., 11.4).
"""

import math
from typing import NamedTuple, Optional

#: Which terms are used; MANUAL: none, the output is given.
MANUAL, P, PI, PID = "manual", "P", "PI", "PID"
MODES = (MANUAL, P, PI, PID)
#: Against windup. CLAMPING: the integral stands still while the output is limited and the error
#: drives it further beyond; simple, and nothing to tune. BACK_CALCULATION: what the limit cuts off
#: takes the integral back, with a time constant; smoother where noise meets the limit. NONE: for
#: lessons about windup.
CLAMPING, BACK_CALCULATION, NONE = "clamping", "back_calculation", "none"
ANTI_WINDUPS = (CLAMPING, BACK_CALCULATION, NONE)
#: The dead zone is compensated in full from this share of it on, so that noise about an output of
#: 0 does not become a rattle between both sides of it.
_RAMP = 0.1


class PidSettings(NamedTuple):
    """What the controller is like.

    :ivar mode: MANUAL, P, PI or PID
    :ivar kp: output for each unit of error
    :ivar ki: output for each unit of error and second, 1/s
    :ivar kd: output for each unit of the measurement's change a second, s
    :ivar filter_time: tf, time constant of the derivative's filter, s, >= 0
    :ivar set_point_weight: b, the share of the set point that the proportional term sees
    :ivar feed_forward: kf, output for each unit of set point
    :ivar output_min: least output
    :ivar output_max: largest output, above the least
    :ivar dead_zone: magnitude of the output that does not move the plant yet; added to each output
    :ivar anti_windup: CLAMPING, BACK_CALCULATION or NONE
    :ivar tracking_time: time constant of the back-calculation, s, > 0
    :ivar manual_output: the output in MANUAL
    """

    mode: str = PID
    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    filter_time: float = 0.0
    set_point_weight: float = 1.0
    feed_forward: float = 0.0
    output_min: float = -1.0
    output_max: float = 1.0
    dead_zone: float = 0.0
    anti_windup: str = CLAMPING
    tracking_time: float = 1.0
    manual_output: float = 0.0

    @property
    def integrates(self) -> bool:
        """Whether there is an integral term."""
        return self.mode in (PI, PID) and self.ki != 0.0

    def limited(self, output: float) -> float:
        """Return an output within the limits."""
        return max(self.output_min, min(self.output_max, output))

    def compensated(self, output: float) -> float:
        """Return an output that is moved out of the dead zone."""
        if self.dead_zone == 0.0:
            return output
        return output + self.dead_zone * max(-1.0, min(1.0, output / (_RAMP * self.dead_zone)))

    def uncompensated(self, output: float) -> float:
        """Return what :meth:`compensated` makes this output of."""
        if abs(output) <= (1.0 + _RAMP) * self.dead_zone:
            return output * _RAMP / (1.0 + _RAMP)
        return output - math.copysign(self.dead_zone, output)


class Terms(NamedTuple):
    """What an output is made of.

    :ivar proportional: kp (b r - y)
    :ivar integral: the integral term
    :ivar derivative: the derivative term
    :ivar feed_forward: kf r
    :ivar unlimited: their sum, moved out of the dead zone, before the limits
    :ivar output: what the plant gets
    """

    proportional: float
    integral: float
    derivative: float
    feed_forward: float
    unlimited: float
    output: float


class Pid:
    """The controller's state, which each measurement moves on.

    A change of settings, also of the mode, does not make the output jump as long as there is an
    integral term, which takes up the difference; nothing else could.

    Not safe for several threads at once.

    :param settings: what it is like
    """

    def __init__(self, settings: PidSettings) -> None:
        self._settings = settings
        self._integral = self._derivative = 0.0
        #: The latest measurement; None where the next one is the first.
        self._measurement: Optional[float] = None
        #: The latest output, and whether the next one goes on from it whatever the terms say.
        self._output, self._resumes = 0.0, False

    def reset(self) -> None:
        """Begin anew: with no integral, and the next measurement the first."""
        self._integral = self._derivative = 0.0
        self._measurement = None
        self._resumes = False

    def change(self, settings: PidSettings) -> None:
        """Go by other settings from the next measurement on.

        :param settings: what it is like
        """
        old, self._settings = self._settings, settings
        if old.mode == MANUAL != settings.mode:
            self.resume(old.manual_output)
        self._resumes = self._resumes or self._measurement is not None
        if settings.mode != PID:
            self._derivative = 0.0

    def resume(self, output: float) -> None:
        """Go on from an output, with the next measurement as if it were the first.

        :param output: what the plant got at last, for whatever reason
        """
        self._measurement = None
        self._derivative = 0.0
        self._output, self._resumes = output, True

    def update(self, set_point: float, measurement: float, interval: float) -> Terms:
        """Return the output that answers a measurement.

        :param set_point: r
        :param measurement: y
        :param interval: dt, time since the measurement before, s; 0 where there is none
        """
        settings = self._settings
        if settings.mode == MANUAL:
            given = settings.manual_output
            return Terms(0.0, 0.0, 0.0, 0.0, given, settings.limited(given))
        proportional = settings.kp * (settings.set_point_weight * set_point - measurement)
        feed_forward = settings.feed_forward * set_point
        self._derivative = self._filtered_derivative(measurement, interval)
        self._measurement = measurement
        rest = proportional + self._derivative + feed_forward
        growth = settings.ki * interval * (set_point - measurement)
        if not settings.integrates:
            growth = self._integral = 0.0
        elif self._resumes:
            # By the limits and the dead zone of now, whatever they were as that was sent.
            growth = 0.0
            self._integral = settings.uncompensated(settings.limited(self._output)) - rest
        self._resumes = False
        integral = self._integral + growth
        unlimited = settings.compensated(rest + integral)
        self._output = output = settings.limited(unlimited)
        self._integral = self._kept(growth, unlimited - output, interval)
        return Terms(proportional, integral, self._derivative, feed_forward, unlimited, output)

    def _filtered_derivative(self, measurement: float, interval: float) -> float:
        settings = self._settings
        if settings.mode != PID or self._measurement is None or interval <= 0.0:
            return self._derivative
        change = settings.kd * (measurement - self._measurement)
        span = settings.filter_time + interval
        return (settings.filter_time * self._derivative - change) / span

    def _kept(self, growth: float, excess: float, interval: float) -> float:
        """Return the integral that the next measurement adds to.

        :param growth: what this measurement adds
        :param excess: how much of the output the limits cut off
        :param interval: dt, s
        """
        settings = self._settings
        if settings.anti_windup == CLAMPING and growth * excess > 0.0:
            return self._integral
        if settings.anti_windup == BACK_CALCULATION and settings.integrates:
            growth += excess * math.expm1(-interval / settings.tracking_time)
        return self._integral + growth
