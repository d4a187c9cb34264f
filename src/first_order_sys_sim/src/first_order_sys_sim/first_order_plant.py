# Pure: knows no ROS.
"""First-order plant, tau dy/dt + y = K u, with a piecewise constant input.

While the input u and the settings are constant, the state is known in closed form::

    y(t) = y(t0) + (K u - y(t0)) (1 - exp(-(t - t0) / tau))

so it is exact at any time, without accumulated errors (zero-order hold; Franklin, Powell, Workman:
Digital Control of Dynamic Systems, section 4.3).
"""

import math
import sys
from typing import NamedTuple

EXACT, EULER = "exact", "euler"
METHODS = (EXACT, EULER)


class PlantSettings(NamedTuple):
    """Parameters of the plant.

    :ivar gain: K, output per unit of input
    :ivar time_constant: tau, > 0 [s]
    :ivar max_output: largest magnitude of the output, > 0
    :ivar min_input: dead zone: an input of this magnitude or less acts as 0
    :ivar method: EXACT, or EULER for the forward difference, whose output changes only when the
        input is held again
    """

    gain: float
    time_constant: float
    max_output: float = math.inf
    min_input: float = 0.0
    method: str = EXACT


class FirstOrderPlant:
    """State of the plant; time starts at 0 and is an argument of each call.

    A time before that of an earlier call counts as that one. The output stops at its limit. Because
    it moves monotonically towards K u, clipping it is what the limited plant does: no hidden state
    winds up, and the output leaves the limit as soon as the input reverses.

    Not thread-safe.

    :param settings: of the plant
    :param output: the state at time 0; clipped to the limit
    """

    def __init__(self, settings: PlantSettings, output: float = 0.0) -> None:
        self._settings = settings
        self._now = 0.0
        self._held = 0.0
        # State at the last change of the held input or of a setting.
        self._restart(output)

    @property
    def held(self) -> float:
        """The current input."""
        return self._held

    def hold(self, time: float, value: float) -> None:
        """Hold another input.

        :param time: from this time on [s]
        :param value: the input u
        """
        self._now = max(time, self._now)
        self._restart(self._response(self._now - self._changed_at))
        self._held = value

    def output(self, time: float) -> float:
        """Return the output at a time.

        :param time: [s]
        :returns: y
        """
        self._now = max(time, self._now)
        # The forward difference changes only when the input is held again.
        seconds = self._now - self._changed_at if self._settings.method == EXACT else 0.0
        return self._response(seconds)

    def change(self, time: float, settings: PlantSettings) -> None:
        """Change the settings; the output continues from its value.

        It jumps only if the new limit is below it, to that limit.

        :param time: [s]
        :param settings: new settings
        """
        output = self.output(time)
        self._settings = settings
        self._restart(output)

    def set_output(self, time: float, value: float) -> None:
        """Set the state of the plant.

        :param time: [s]
        :param value: the output; clipped to the limit
        """
        self._now = max(time, self._now)
        self._restart(value)

    def _restart(self, output: float) -> None:
        self._start, self._changed_at = self._limited(output), self._now

    def _limited(self, output: float) -> float:
        return max(-self._settings.max_output, min(self._settings.max_output, output))

    def _response(self, seconds: float) -> float:
        """Return the output a time after the last change [s]."""
        gain, time_constant, _, dead_zone, method = self._settings
        target = gain * self._held if abs(self._held) > dead_zone else 0.0
        # Finite even for a tiny tau: 0 times infinity would be NaN.
        ratio = min(seconds / time_constant, sys.float_info.max)
        approached = -math.expm1(-ratio) if method == EXACT else ratio
        return self._limited(self._start + (target - self._start) * approached)
