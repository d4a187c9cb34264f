# Pure: knows no ROS.
"""A plant behind a sampler that holds its input."""

import math

from first_order_sys_sim.first_order_plant import EXACT, FirstOrderPlant, PlantSettings

#: How close to a sample a moment counts as the sample itself, in sample times.
_EDGE = 1e-9
#: How many samples are taken one by one, with EULER, of those up to a moment far ahead: a simulated
#: clock may leap by years, which would take as long.
_MOST_ONE_BY_ONE = 10_000


class SampledPlant:
    """A :class:`.FirstOrderPlant` whose input is sampled at time 0 and every sample time.

    Inputs may come and outputs may be asked for at any moment, at samples or not, with the times of
    the calls never decreasing. Not safe for several threads at once.

    :param settings: what the plant is like
    :param sample_time: how often the input is sampled, s, > 0
    :param output: the state at time 0; cut off at the limit
    """

    def __init__(self, settings: PlantSettings, sample_time: float, output: float = 0.0) -> None:
        self._plant = FirstOrderPlant(settings, output)
        self._settings = settings
        self._sample_time = sample_time
        self._now = 0.0
        self._input = 0.0
        # Sample n is due at _grid + n sample_time; _next is the n of the next one.
        self._grid, self._next = 0.0, 0
        self._sampled_at = 0.0

    def set_input(self, time: float, value: float) -> None:
        """Let the sampler find another input from now on.

        :param time: the moment, s; a sample at this very moment finds the new input
        :param value: the input u
        """
        self._advance(time)
        self._input = value
        if self._now - self._sampled_at <= _EDGE * self._sample_time:
            self._plant.hold(self._now, value)

    def output(self, time: float) -> float:
        """Return the output at a moment.

        :param time: the moment, s
        :returns: y
        """
        self._advance(time)
        return self._plant.output(self._now)

    def change(self, time: float, settings: PlantSettings, sample_time: float) -> None:
        """Change the settings; the output goes on from where it is, see :class:`.FirstOrderPlant`.

        :param time: the moment, s
        :param settings: what the plant is like from now on
        :param sample_time: how often the input is sampled, counted from the last sample, s
        """
        self._advance(time)
        self._plant.change(self._now, settings)
        self._settings = settings
        self._grid, self._next = self._sampled_at, 1
        self._sample_time = sample_time

    def set_output(self, time: float, value: float) -> None:
        """Put the plant into a state.

        :param time: the moment, s
        :param value: the output; cut off at the limit
        """
        self._advance(time)
        self._plant.set_output(self._now, value)

    def _advance(self, time: float) -> None:
        """Take the samples up to a moment."""
        self._now = max(time, self._now)
        last = math.floor((self._now - self._grid) / self._sample_time + _EDGE)
        while self._next <= last:
            due = min(self._grid + self._next * self._sample_time, self._now)
            self._next += 1
            if self._settings.method == EXACT:
                if self._input != self._plant.held:
                    self._plant.hold(due, self._input)
                self._next = last + 1  # the others find the same input
            else:
                self._plant.hold(due, self._input)
                if last - self._next > _MOST_ONE_BY_ONE:
                    self._plant.change(due, self._settings._replace(method=EXACT))
                    self._next = last - _MOST_ONE_BY_ONE
                    self._plant.change(self._grid + self._next * self._sample_time, self._settings)
        self._sampled_at = self._grid + last * self._sample_time
