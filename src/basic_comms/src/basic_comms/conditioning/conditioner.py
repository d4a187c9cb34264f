"""Signal conditioning, sample by sample: scale, phase shift, offset and a lift above zero.

For samples of A sin(theta) the result is

    scale * A * sin(theta + shift) + offset + lift,   lift = max(0, |scale * A| - offset) or 0

where sin(theta + shift) = sin(theta) cos(shift) + cos(theta) sin(shift). The first sine is the
sample itself: without a phase shift any signal passes unchanged except for scale, offset and lift.
This is the method ``sine``. The method ``delay`` works for any periodic shape f instead of A sin:
it looks up f(theta + shift) in the latest period, and does not shift until a period is complete.
"""

import math
from typing import Optional

from basic_comms.conditioning.delay_line import PhaseDelayLine
from basic_comms.conditioning.phase_tracking import PhaseTracker
from basic_comms.conditioning.process_parameters import ProcessParameters
from nodekit import LARGEST_FLOAT32


class Conditioner:
    """Conditioner of the samples of a signal.

    A sample with neither amplitude nor frequency is from a stopped generator. Its value passes
    without a shift, and the phase is kept until the signal continues.

    Settings affect only the output, and both methods follow every sample: a change of settings
    applies from the next sample on and has no after-effects.
    """

    def __init__(self) -> None:
        #: Number of samples without an output, see :meth:`process`.
        self.rejected = 0
        self._tracker = PhaseTracker()
        self._line = PhaseDelayLine()
        self._adopt(ProcessParameters())

    @property
    def restarts(self) -> int:
        """Number of times that time_x repeated or ran backwards, which restarts the tracking."""
        return self._tracker.restarts

    def process(
        self,
        amplitude: float,
        frequency: float,
        time_x: float,
        signal_y: float,
        settings: ProcessParameters,
    ) -> Optional[float]:
        """Process one sample and return the conditioned one.

        :param amplitude: peak of the signal around input_offset
        :param frequency: angular frequency since the previous sample [rad/s]
        :param time_x: time of the sample [s]
        :param signal_y: value of the signal
        :param settings: an immutable snapshot; read only when the object changes
        :returns: conditioned value; None if a field is not finite (the sample is then dropped) or
            the value does not fit into a float32
        """
        if not math.isfinite(amplitude + frequency + time_x + signal_y):
            self.rejected += 1
            return None
        if settings is not self._settings:
            self._adopt(settings)
        if amplitude or frequency:
            shifted = self._shift(amplitude, frequency, time_x, signal_y)
        else:
            shifted = signal_y - self._input_offset
        result = self._scale * shifted + self._offset
        if self._keep_positive:
            result += max(0.0, abs(self._scale * amplitude) - self._offset)
        if not abs(result) <= LARGEST_FLOAT32:
            self.rejected += 1
            return None
        return result

    def _shift(self, amplitude: float, frequency: float, time_x: float, signal_y: float) -> float:
        quadrature = self._tracker.update(
            amplitude, frequency, time_x, signal_y, self._input_offset
        )
        self._line.push(frequency, time_x, signal_y)
        if self._delays:
            earlier = self._line.value(self._phase_shift)
            return (signal_y if earlier is None else earlier) - self._input_offset
        return (signal_y - self._input_offset) * self._cosine + quadrature * self._sine

    def _adopt(self, settings: ProcessParameters) -> None:
        self._settings = settings
        self._scale = settings.amplitude_scale
        self._delays = settings.method == "delay"
        self._phase_shift = settings.phase_shift
        self._cosine = math.cos(settings.phase_shift)
        self._sine = math.sin(settings.phase_shift)
        self._offset = settings.offset
        self._keep_positive = settings.keep_positive
        self._input_offset = settings.input_offset
