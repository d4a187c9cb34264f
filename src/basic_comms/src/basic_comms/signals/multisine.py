"""Multisine: a sum of sines, the usual test signal for frequency responses."""

import math
from typing import List, Sequence

from basic_comms.signals.oscillator import PhaseAccumulator


class Multisine:
    """Sum of sines whose components can be changed at any sample without a jump of their phases.

    Each component has its own oscillator. A component added later starts as if it had always been
    there.
    """

    def __init__(self) -> None:
        self._oscillators: List[PhaseAccumulator] = []

    def value(
        self,
        time: float,
        amplitudes: Sequence[float],
        frequencies: Sequence[float],
        phases: Sequence[float],
    ) -> float:
        """Return the next sample, relative to the sum of all amplitudes.

        The three lists have the same length. If all amplitudes are 0, the value is 0.

        :param time: time of the sample [s]
        :param amplitudes: relative amplitudes of the components
        :param frequencies: angular frequencies of the components [rad/s]
        :param phases: constants added to the phases of the components [rad]
        :returns: value in [-1, 1]
        """
        count = len(frequencies)
        while len(self._oscillators) < count:
            self._oscillators.append(PhaseAccumulator())
        del self._oscillators[count:]
        value = total = 0.0
        for oscillator, amplitude, frequency, phase in zip(
            self._oscillators, amplitudes, frequencies, phases
        ):
            value += amplitude * math.sin(oscillator.advance(time, frequency) + phase)
            total += abs(amplitude)
        return value / total if total else 0.0
