"""A sampled plant whose input takes a while to arrive."""

from collections import deque
from typing import Deque, Tuple

from first_order_sys_sim.first_order_plant import PlantSettings
from first_order_sys_sim.sampled_plant import SampledPlant


class DelayedPlant:
    """A :class:`.SampledPlant` that finds each input a dead time after it was given.

    The times of the calls never decrease. Not safe for several threads at once.

    :param plant: the plant
    :param dead_time: how long an input takes, s, >= 0
    """

    def __init__(self, plant: SampledPlant, dead_time: float) -> None:
        self._plant = plant
        self._dead_time = dead_time
        #: Inputs under way, and when they arrive, s.
        self._coming: Deque[Tuple[float, float]] = deque()

    def set_input(self, time: float, value: float) -> None:
        """Give it an input; none overtakes another, also where the dead time became shorter.

        :param time: the moment, s
        :param value: the input u
        """
        arrival = time + self._dead_time
        self._coming.append((max(arrival, self._coming[-1][0] if self._coming else 0.0), value))
        self._advance(time)

    def output(self, time: float) -> float:
        """Return the output at a moment.

        :param time: the moment, s
        :returns: y
        """
        self._advance(time)
        return self._plant.output(time)

    def change(
        self, time: float, settings: PlantSettings, sample_time: float, dead_time: float
    ) -> None:
        """Change the settings; the output goes on from where it is.

        :param time: the moment, s
        :param settings: what the plant is like from now on
        :param sample_time: how often the input is sampled, s
        :param dead_time: how long an input takes that is given from now on, s
        """
        self._advance(time)
        self._plant.change(time, settings, sample_time)
        self._dead_time = dead_time

    def set_output(self, time: float, value: float) -> None:
        """Put the plant into a state.

        :param time: the moment, s
        :param value: the output; cut off at the limit
        """
        self._advance(time)
        self._plant.set_output(time, value)

    def _advance(self, time: float) -> None:
        while self._coming and self._coming[0][0] <= time:
            self._plant.set_input(*self._coming.popleft())
