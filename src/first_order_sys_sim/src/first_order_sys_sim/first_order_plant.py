"""A first-order plant, tau dy/dt + y = K u, behind a sampler that holds its input.

While the held input u and the settings stay the same, the state is known in closed form::

    y(t) = y(t0) + (K u - y(t0)) (1 - exp(-(t - t0) / tau))

so it is exact at any moment, at samples and between them, and nothing adds up from sample to sample
(zero-order hold; Franklin, Powell, Workman: Digital Control of Dynamic Systems, section 4.3).
"""

import math
from typing import NamedTuple

EXACT, EULER = "exact", "euler"
METHODS = (EXACT, EULER)

#: How close to a sample a moment counts as the sample itself, in sample times.
_EDGE = 1e-9


class PlantSettings(NamedTuple):
    """What the plant is like.

    :ivar gain: K, output for each unit of input
    :ivar time_constant: tau, s, > 0
    :ivar sample_time: how often the input is sampled, s, > 0
    :ivar max_output: largest magnitude of the output, > 0
    :ivar min_input: dead zone: an input of this magnitude or less acts as 0
    :ivar method: EXACT, or EULER for the forward difference, whose output is new at samples only
    """

    gain: float
    time_constant: float
    sample_time: float
    max_output: float = math.inf
    min_input: float = 0.0
    method: str = EXACT


class FirstOrderPlant:
    """The plant's state, in a time that starts at 0 and is given with each call.

    A time before one that was given already counts as that one. Samples are taken at 0 and every
    sample time. The output stops at its limit, and since it moves towards K u and never past it,
    to cut it off there is what the limited plant does: there is no hidden state that winds up, and
    the output leaves the limit with the first sample that turns it round.

    Not safe for several threads at once.

    :param settings: what the plant is like
    :param output: the state at time 0; cut off at the limit
    """

    def __init__(self, settings: PlantSettings, output: float = 0.0) -> None:
        self._settings = settings
        self._now = 0.0
        self._input = 0.0
        self._held = 0.0
        # The state at the last moment at which the held input or a setting changed.
        self._begun, self._begun_at = output, 0.0
        # Sample n is due at _grid + n sample_time; _next is the n of the next one.
        self._grid, self._next = 0.0, 0
        self._sampled_at = -math.inf

    def set_input(self, time: float, value: float) -> None:
        """Let the sampler find another input from now on.

        :param time: the moment, s; a sample that is due at it finds the new input
        :param value: the input u
        """
        self._advance(time)
        self._input = value
        if self._now - self._sampled_at <= _EDGE * self._settings.sample_time:
            self._hold_input(self._now)

    def output(self, time: float) -> float:
        """Return the output at a moment.

        :param time: the moment, s
        :returns: y
        """
        self._advance(time)
        return self._state()

    def change(self, time: float, settings: PlantSettings) -> None:
        """Change the settings; the output goes on from where it is.

        Only a new limit below the output moves it, to that limit. A new sample time counts from the
        last sample.

        :param time: the moment, s
        :param settings: what the plant is like from now on
        """
        self._advance(time)
        self._begun, self._begun_at = self._state(), self._now
        if settings.sample_time != self._settings.sample_time:
            self._grid = max(self._sampled_at + settings.sample_time, self._now)
            self._next = 0
        self._settings = settings

    def set_output(self, time: float, value: float) -> None:
        """Put the plant into a state.

        :param time: the moment, s
        :param value: the output; cut off at the limit
        """
        self._advance(time)
        self._begun, self._begun_at = value, self._now

    def _advance(self, time: float) -> None:
        """Take the samples up to a moment."""
        self._now = max(time, self._now)
        sample_time, method = self._settings.sample_time, self._settings.method
        last = math.floor((self._now - self._grid) / sample_time + _EDGE)
        while self._next <= last:
            if self._input != self._held or method == EULER:
                self._hold_input(min(self._grid + self._next * sample_time, self._now))
            # All further ones find the same input, which matters to the forward difference only.
            self._next = self._next + 1 if method == EULER else last + 1
        if last >= 0:
            self._sampled_at = self._grid + last * sample_time

    def _hold_input(self, moment: float) -> None:
        self._begun, self._begun_at = self._response(moment - self._begun_at), moment
        self._held = self._input

    def _state(self) -> float:
        # Between samples the forward difference knows nothing new.
        seconds = self._now - self._begun_at if self._settings.method == EXACT else 0.0
        return self._response(seconds)

    def _response(self, seconds: float) -> float:
        """Return the output a time after that moment, s."""
        gain, time_constant, _, limit, dead_zone, method = self._settings
        target = gain * self._held if abs(self._held) > dead_zone else 0.0
        ratio = seconds / time_constant
        approached = -math.expm1(-ratio) if method == EXACT else ratio
        return max(-limit, min(limit, self._begun + (target - self._begun) * approached))
