# Pure: knows no ROS.
"""A first-order plant, tau dy/dt + y = K u, whose input is held from one moment to the next.

While the held input u and the settings stay the same, the state is known in closed form::

    y(t) = y(t0) + (K u - y(t0)) (1 - exp(-(t - t0) / tau))

so it is exact at any moment, and nothing adds up from sample to sample (zero-order hold; Franklin,
Powell, Workman: Digital Control of Dynamic Systems, section 4.3).
"""

import math
import sys
from typing import NamedTuple

EXACT, EULER = "exact", "euler"
METHODS = (EXACT, EULER)


class PlantSettings(NamedTuple):
    """Parameters of the plant.

    :ivar gain: K, output for each unit of input
    :ivar time_constant: tau, s, > 0
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
    """The plant's state, in a time that starts at 0 and is given with each call.

    A time before one that was given already counts as that one. The output stops at its limit, and
    since it moves towards K u and never past it, to cut it off there is what the limited plant
    does: there is no hidden state that winds up, and the output leaves the limit at once when the
    input turns it round.

    Not safe for several threads at once.

    :param settings: what the plant is like
    :param output: the state at time 0; cut off at the limit
    """

    def __init__(self, settings: PlantSettings, output: float = 0.0) -> None:
        self._settings = settings
        self._now = 0.0
        self._held = 0.0
        # The state at the last moment at which the held input or a setting changed.
        self._start, self._changed_at = output, 0.0

    @property
    def held(self) -> float:
        """The input that acts now."""
        return self._held

    def hold(self, time: float, value: float) -> None:
        """Hold another input.

        :param time: from which moment on, s
        :param value: the input u
        """
        self._now = max(time, self._now)
        self._restart(self._response(self._now - self._changed_at))
        self._held = value

    def output(self, time: float) -> float:
        """Return the output at a moment.

        :param time: the moment, s
        :returns: y
        """
        self._now = max(time, self._now)
        # Until the input is held again, the forward difference knows nothing new.
        seconds = self._now - self._changed_at if self._settings.method == EXACT else 0.0
        return self._response(seconds)

    def change(self, time: float, settings: PlantSettings) -> None:
        """Change the settings; the output goes on from where it is.

        Only a new limit below the output moves it, to that limit.

        :param time: the moment, s
        :param settings: what the plant is like from now on
        """
        self._restart(self.output(time))
        self._settings = settings

    def set_output(self, time: float, value: float) -> None:
        """Put the plant into a state.

        :param time: the moment, s
        :param value: the output; cut off at the limit
        """
        self._now = max(time, self._now)
        self._restart(value)

    def _restart(self, output: float) -> None:
        self._start, self._changed_at = output, self._now

    def _response(self, seconds: float) -> float:
        """Return the output a time after the last change, s."""
        gain, time_constant, limit, dead_zone, method = self._settings
        target = gain * self._held if abs(self._held) > dead_zone else 0.0
        # Finite also where tau is next to nothing: 0 times infinity would be NaN.
        ratio = min(seconds / time_constant, sys.float_info.max)
        approached = -math.expm1(-ratio) if method == EXACT else ratio
        return max(-limit, min(limit, self._start + (target - self._start) * approached))
