"""Phase delay line: shifts the phase of a periodic signal of any shape.

A lead of s rad equals a lag of 2 pi - s, which stored samples provide. Each sample is stored with
its phase, so the frequency and the sample rate may change.

Between samples the value follows the parabola through the two neighbours and the further neighbour
that bends it less (essentially non-oscillatory, ENO; Harten et al., J. Comput. Phys. 71, 1987), so
edges do not ring. Samples evenly D rad apart give a sine to 0.065 D^3 of its amplitude, a straight
line exactly, and an edge between the two samples at which it occurred. Between the latest two
samples, and across a gap, the value follows a straight line, which gives a sine to D^2 / 8.
"""

import bisect
import math
from typing import List, Optional

_TURN = 2.0 * math.pi
# Samples closer than this are thinned out, which bounds the memory: at most 4096 samples
# a period, and as many waiting to be removed.
_SPACING = _TURN / 2048.0
# A parabola is used only if the neighbours are at most this much farther apart than the next ones.
_UNEVEN = 2.0


class PhaseDelayLine:
    """Memory of the latest period of a signal, with its value at any phase.

    All arguments must be finite. A gap of a period or more, or a time_x that repeats or runs
    backwards, clears the memory. When the frequency changes its sign, the signal retraces itself.
    """

    def __init__(self) -> None:
        self._time = -math.inf
        self._direction = 1.0
        # Phase and value of each sample, oldest first.
        self._phases: List[float] = []
        self._values: List[float] = []

    def push(self, frequency: float, time_x: float, value: float) -> None:
        """Add one sample.

        :param frequency: angular frequency since the previous sample [rad/s]
        :param time_x: time of the sample [s]
        :param value: value of the signal
        """
        advance = abs(frequency) * (time_x - self._time)
        usable = time_x > self._time and advance < _TURN
        self._time = time_x
        if frequency * self._direction < 0.0:
            self._direction = -self._direction
            self._retrace()
        phases = self._phases
        values = self._values
        if not usable or not phases:
            phases[:] = [0.0]
            values[:] = [value]
            return
        phase = phases[-1] + advance
        if len(phases) > 1 and phase - phases[-2] < _SPACING:
            phases[-1] = phase
            values[-1] = value
        else:
            phases.append(phase)
            values.append(value)
            # Rarely, because it is slow; restarting from zero keeps phases small and so exact.
            if phase > 2.0 * _TURN:
                self._drop(phase - _TURN)

    def value(self, lead: float) -> Optional[float]:
        """Return the value at a phase ahead of the latest sample.

        :param lead: phase ahead of the latest sample [rad]
        :returns: value of the signal when it last had that phase; None if the memory is too short
        """
        phases = self._phases
        if not phases:
            return None
        target = phases[-1] - (-self._direction * lead) % _TURN
        if target < phases[0]:
            return None
        after = bisect.bisect_right(phases, target)
        if after == len(phases):
            return self._values[-1]
        return self._interpolate(after, target)

    def _interpolate(self, after: int, target: float) -> float:
        """Return the value at a phase between the samples at after - 1 and after."""
        phases = self._phases
        values = self._values
        width = phases[after] - phases[after - 1]
        rise = values[after] - values[after - 1]
        fraction = (target - phases[after - 1]) / width
        value = values[after - 1] + fraction * rise
        if after < 2 or after + 1 == len(phases):
            return value
        before = (phases[after - 1] - phases[after - 2]) / width
        beyond = (phases[after + 1] - phases[after]) / width
        if _UNEVEN * min(before, beyond) < 1.0:
            return value
        bend = (rise - (values[after - 1] - values[after - 2]) / before) / (1.0 + before)
        other = ((values[after + 1] - values[after]) / beyond - rise) / (1.0 + beyond)
        if abs(other) < abs(bend):
            bend = other
        return value - bend * fraction * (1.0 - fraction)

    def _drop(self, oldest: float) -> None:
        """Drop the samples before a phase, except two that interpolation needs."""
        phases = self._phases
        spare = max(0, bisect.bisect_right(phases, oldest) - 2)
        start = phases[spare]
        phases[:] = [phase - start for phase in phases[spare:]]
        del self._values[:spare]

    def _retrace(self) -> None:
        """Reverse the memory for a phase that runs backwards: values ahead are a period old."""
        phases = self._phases
        values = self._values
        self._phases = []
        self._values = []
        if phases and phases[-1] - phases[0] >= _TURN:
            now = phases[-1]
            kept = bisect.bisect_left(phases, now - _TURN)
            self._phases = [2.0 * now - _TURN - phase for phase in reversed(phases[kept:])] + [now]
            self._values = values[kept:][::-1] + [values[-1]]
