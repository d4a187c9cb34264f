"""PID controller with a limited output: proportional, integral, derivative, feed-forward.

In continuous time, with set point r, measurement y and unlimited output v::

    v = kp (b r - y) + ki integral(r - y) - kd dy/dt / (1 + tf d/dt) + kf r

(Åström, Murray: Feedback Systems, 2nd edition, section 11.1 and, for the weight b and the filtered
derivative of the measurement, 11.5.) It is computed at each measurement, a time dt after the last
one, by backward differences (ibid., 11.5, "Implementation")::

    I[n] = I[n-1] + ki dt (r - y[n])
    D[n] = (tf D[n-1] - kd (y[n] - y[n-1])) / (tf + dt)

which are stable for any dt. The integral must not grow while the output is limited: the output
would leave its limit late (windup, ibid., 11.4).
"""

import math
from typing import NamedTuple, Optional

#: Active terms; in MANUAL the output is a setting.
MANUAL, P, PI, PID = "manual", "P", "PI", "PID"
MODES = (MANUAL, P, PI, PID)
#: Anti-windup methods. CLAMPING: the integral is held while the output is limited and the error
#: drives it further beyond; nothing to tune. BACK_CALCULATION: the clipped part of the output
#: reduces the integral with a time constant; smoother if noise meets the limit. NONE: to teach
#: windup.
CLAMPING, BACK_CALCULATION, NONE = "clamping", "back_calculation", "none"
ANTI_WINDUPS = (CLAMPING, BACK_CALCULATION, NONE)
#: Output, as a share of the dead zone, at which the compensation is complete: a ramp up to there
#: keeps noise about 0 from jumping between both sides of the dead zone.
_RAMP = 0.1


class PidSettings(NamedTuple):
    """Settings of the controller.

    :ivar mode: MANUAL, P, PI or PID
    :ivar kp: proportional gain: output per unit of error
    :ivar ki: integral gain: output per unit of error and second [1/s]
    :ivar kd: derivative gain: output per unit of the measurement's rate of change [s]
    :ivar filter_time: tf, time constant of the derivative filter, >= 0 [s]
    :ivar set_point_weight: b, share of the set point in the proportional term
    :ivar feed_forward: kf, output per unit of set point
    :ivar output_min: lower limit of the output
    :ivar output_max: upper limit of the output
    :ivar dead_zone: largest output that does not move the plant; added to each output
    :ivar anti_windup: CLAMPING, BACK_CALCULATION or NONE
    :ivar tracking_time: time constant of the back-calculation, > 0 [s]
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
        """True if the integral term is active."""
        return self.mode in (PI, PID) and self.ki != 0.0

    def limited(self, output: float) -> float:
        """Clip an output to the limits."""
        return max(self.output_min, min(self.output_max, output))

    def compensated(self, output: float) -> float:
        """Move an output out of the dead zone."""
        if self.dead_zone == 0.0:
            return output
        return output + self.dead_zone * max(-1.0, min(1.0, output / (_RAMP * self.dead_zone)))

    def uncompensated(self, output: float) -> float:
        """Return the output before :meth:`compensated`, its inverse."""
        if abs(output) <= (1.0 + _RAMP) * self.dead_zone:
            return output * _RAMP / (1.0 + _RAMP)
        return output - math.copysign(self.dead_zone, output)


class Terms(NamedTuple):
    """The terms of an output.

    :ivar proportional: kp (b r - y)
    :ivar integral: the integral term
    :ivar derivative: the derivative term
    :ivar feed_forward: kf r
    :ivar unlimited: sum of the terms, compensated for the dead zone, before clipping
    :ivar output: the clipped output, sent to the plant
    """

    proportional: float
    integral: float
    derivative: float
    feed_forward: float
    unlimited: float
    output: float


class Pid:
    """PID controller, updated by each measurement.

    A change of settings or mode does not make the output jump if the integral term is active: it
    absorbs the difference. With ki 0 the integral is held; the modes without it clear it.

    Not thread-safe.

    :param settings: the controller's settings
    """

    def __init__(self, settings: PidSettings) -> None:
        self._settings = settings
        self._integral = self._derivative = 0.0
        #: The latest measurement; None before the first one.
        self._measurement: Optional[float] = None
        #: The latest output, and whether the next one continues from it (bumpless transfer).
        self._output, self._resumes = 0.0, False

    def reset(self) -> None:
        """Clear the integral, and treat the next measurement as the first."""
        self._integral = self._derivative = 0.0
        self._measurement = None
        self._resumes = False

    def change(self, settings: PidSettings) -> None:
        """Apply new settings from the next measurement on.

        :param settings: the new settings
        """
        old, self._settings = self._settings, settings
        if old.mode == MANUAL != settings.mode:
            self.resume(old.manual_output)
        self._resumes = self._resumes or self._measurement is not None
        if settings.mode != PID:
            self._derivative = 0.0

    def resume(self, output: float) -> None:
        """Continue from an output, and treat the next measurement as the first.

        :param output: the latest input of the plant, whatever sent it
        """
        self._measurement = None
        self._derivative = 0.0
        self._output, self._resumes = output, True

    def update(self, set_point: float, measurement: float, interval: float) -> Terms:
        """Compute the output for a measurement.

        :param set_point: r
        :param measurement: y
        :param interval: dt, time since the previous measurement; 0 for the first one [s]
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
        if settings.mode not in (PI, PID):
            growth = self._integral = 0.0
        elif self._resumes and settings.integrates:
            # The current limits and dead zone apply, whatever they were for the latest output.
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
        """Return the new integral, with the anti-windup method applied.

        :param growth: the increment of this measurement
        :param excess: clipped part of the output
        :param interval: dt [s]
        """
        settings = self._settings
        if settings.anti_windup == CLAMPING and growth * excess > 0.0:
            return self._integral
        if settings.anti_windup == BACK_CALCULATION and settings.integrates:
            growth += excess * math.expm1(-interval / settings.tracking_time)
        return self._integral + growth
