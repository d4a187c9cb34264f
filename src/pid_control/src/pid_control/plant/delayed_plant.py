"""A sampled plant with a dead time at its input."""

from collections import deque
from typing import Deque, Tuple

from first_order_sys_sim.first_order_plant import PlantSettings
from first_order_sys_sim.sampled_plant import SampledPlant


class DelayedPlant:
    """A :class:`.SampledPlant` with a dead time at its input.

    The times of the calls never decrease. Not thread-safe.

    :param plant: the plant
    :param dead_time: delay of each input, >= 0 [s]
    """

    def __init__(self, plant: SampledPlant, dead_time: float) -> None:
        self._plant = plant
        self._dead_time = dead_time
        #: Delayed inputs: time of arrival [s] and value.
        self._coming: Deque[Tuple[float, float]] = deque()

    def set_input(self, time: float, value: float) -> None:
        """Set the input; inputs keep their order even if the dead time becomes shorter.

        :param time: now [s]
        :param value: the input u
        """
        arrival = time + self._dead_time
        self._coming.append((max(arrival, self._coming[-1][0] if self._coming else 0.0), value))
        self._advance(time)

    def output(self, time: float) -> float:
        """Return the output y.

        :param time: now [s]
        """
        self._advance(time)
        return self._plant.output(time)

    def change(
        self, time: float, settings: PlantSettings, sample_time: float, dead_time: float
    ) -> None:
        """Change the settings without a jump of the output.

        :param time: now [s]
        :param settings: the plant's new settings
        :param sample_time: sample time of the input [s]
        :param dead_time: delay of the inputs from now on [s]
        """
        self._advance(time)
        self._plant.change(time, settings, sample_time)
        self._dead_time = dead_time

    def set_output(self, time: float, value: float) -> None:
        """Set the output, which is the plant's state.

        :param time: now [s]
        :param value: the output; clipped to the limit
        """
        self._advance(time)
        self._plant.set_output(time, value)

    def _advance(self, time: float) -> None:
        while self._coming and self._coming[0][0] <= time:
            self._plant.set_input(*self._coming.popleft())
