# Pure: knows no ROS.
"""Plant with a sampler that holds its input."""

import math

from first_order_sys_sim.first_order_plant import EXACT, FirstOrderPlant, PlantSettings

#: A time this close to a sample counts as the sample itself, in sample times.
_EDGE = 1e-9
#: Most samples computed one by one with EULER, of those up to a distant time: a simulated clock may
#: jump by years.
_MOST_ONE_BY_ONE = 10_000


class SampledPlant:
    """:class:`.FirstOrderPlant` whose input is sampled at time 0 and every sample time.

    Inputs and outputs may be at any time, at samples or not; the times of the calls must not
    decrease. Not thread-safe.

    :param settings: of the plant
    :param sample_time: sample time of the input, > 0 [s]
    :param output: the state at time 0; clipped to the limit
    """

    def __init__(self, settings: PlantSettings, sample_time: float, output: float = 0.0) -> None:
        self._plant = FirstOrderPlant(settings, output)
        self._settings = settings
        self._sample_time = sample_time
        self._now = 0.0
        self._input = 0.0
        # Sample n is at _grid + n sample_time; _next is the n of the next one.
        self._grid, self._next = 0.0, 0
        self._sampled_at = 0.0

    def set_input(self, time: float, value: float) -> None:
        """Set the input for the following samples.

        :param time: [s]; a sample at exactly this time uses the new input
        :param value: the input u
        """
        self._advance(time)
        self._input = value
        if self._now - self._sampled_at <= _EDGE * self._sample_time:
            self._plant.hold(self._now, value)

    def output(self, time: float) -> float:
        """Return the output at a time.

        :param time: [s]
        :returns: y
        """
        self._advance(time)
        return self._plant.output(self._now)

    def change(self, time: float, settings: PlantSettings, sample_time: float) -> None:
        """Change the settings; the output continues, see :class:`.FirstOrderPlant`.

        :param time: [s]
        :param settings: new settings
        :param sample_time: sample time of the input, counted from the last sample [s]
        """
        self._advance(time)
        self._plant.change(self._now, settings)
        self._settings = settings
        self._grid, self._next = self._sampled_at, 1
        self._sample_time = sample_time

    def set_output(self, time: float, value: float) -> None:
        """Set the state of the plant.

        :param time: [s]
        :param value: the output; clipped to the limit
        """
        self._advance(time)
        self._plant.set_output(self._now, value)

    def _advance(self, time: float) -> None:
        """Process the samples up to a time."""
        self._now = max(time, self._now)
        last = math.floor((self._now - self._grid) / self._sample_time + _EDGE)
        while self._next <= last:
            due = min(self._grid + self._next * self._sample_time, self._now)
            self._next += 1
            if self._settings.method == EXACT:
                if self._input != self._plant.held:
                    self._plant.hold(due, self._input)
                self._next = last + 1  # the others have the same input
            else:
                self._plant.hold(due, self._input)
                if last - self._next > _MOST_ONE_BY_ONE:
                    self._plant.change(due, self._settings._replace(method=EXACT))
                    self._next = last - _MOST_ONE_BY_ONE
                    self._plant.change(self._grid + self._next * self._sample_time, self._settings)
        self._sampled_at = self._grid + last * self._sample_time
