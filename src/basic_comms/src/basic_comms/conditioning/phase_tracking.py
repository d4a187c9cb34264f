"""Phase tracker of a sampled sine, which returns the quadrature (cosine) of each sample.

A message has the amplitude, angular frequency, time and value of a sample. They give the advance of
the phase since the previous sample and the value of the sine, each with its largest error from
rounding to float32; :mod:`basic_comms.conditioning.phase_estimate` does the rest.
"""

import math

from basic_comms.conditioning.phase_estimate import LEAST_TOLERANCE, PhaseEstimate

# Half a unit in the last place of float32, relative.
_ROUNDING = 2.0**-24
# Rounding of time_x and of frequency * time_x in double precision at both ends of a step, relative.
_TIME_ROUNDING = 2.0**-51
# A step whose advance is less certain than this [rad] gives no information on the next phase.
_LOST = 1.0
# Deviation of a sweep from linear between two samples, relative to its share of the advance.
_SWEEP_ROUGHNESS = 1e-3
# A smaller amplitude is near float32's subnormal numbers, which have no relative precision.
_LEAST_AMPLITUDE = 1e-36


class PhaseTracker:
    """Tracker of the phase of amplitude * sin(phase), from received samples.

    All arguments must be finite. With zero amplitude or frequency the phase is kept. An input that
    is not a sine of the stated amplitude and frequency is ignored for one period, and pulls the
    phase gently from then on. A sine that jumps is found from two new samples. If a sample
    contradicts the latest frequency, the mean frequency of the latest two samples is tried, which
    is that of a sweep.
    """

    __slots__ = ("restarts", "_time", "_frequency", "_sweeps", "_estimate")

    def __init__(self) -> None:
        #: Number of times that time_x repeated or ran backwards, which restarts the tracking.
        self.restarts = 0
        # Of the previous sample [s], [rad/s]. Initially so long ago that no phase follows from it.
        self._time = -math.inf
        self._frequency = 0.0
        # Whether the frequency changes gradually between samples, not in steps at samples.
        self._sweeps = False
        self._estimate = PhaseEstimate()

    def update(
        self,
        amplitude: float,
        frequency: float,
        time_x: float,
        signal_y: float,
        input_offset: float = 0.0,
    ) -> float:
        """Process one sample.

        :param amplitude: peak value of the sine, in the unit of signal_y
        :param frequency: angular frequency since the previous sample [rad/s]
        :param time_x: time of the sample [s]
        :param signal_y: value of the sine, around input_offset
        :param input_offset: mean value of signal_y
        :returns: amplitude * cos(phase) at this sample
        """
        # Not split into functions: each call here takes 7 % of the total time.
        if time_x <= self._time:
            self.restarts += 1
            self._time = -math.inf
        step = time_x - self._time
        self._time = time_x
        advance = frequency * step
        slack = _ROUNDING * abs(advance) + _TIME_ROUNDING * abs(frequency * time_x)
        further = 0.0
        if frequency == self._frequency:
            self._sweeps = False
        else:
            # Further advance of the phase by the mean frequency, compared with the latest one.
            further = 0.5 * (self._frequency - frequency) * step
            self._frequency = frequency
            if self._sweeps:
                advance += further
                slack += _SWEEP_ROUGHNESS * abs(further)
                further = -further
        if not slack < _LOST:  # it may be NaN
            # Earlier samples give no information. A generator without changes obeys phase = w t.
            self._estimate.start(frequency * time_x)
            advance = slack = further = 0.0
        if -_LEAST_AMPLITUDE < amplitude < _LEAST_AMPLITUDE:
            self._estimate.advance(advance, slack)
            return amplitude * math.cos(self._estimate.phase)
        value = (signal_y - input_offset) / amplitude
        tolerance = _ROUNDING * (abs(value) + abs(signal_y / amplitude)) + LEAST_TOLERANCE
        cosine = self._estimate.follow(advance, slack, value, tolerance)
        if cosine is None:
            cosine = self._search(value, tolerance, advance, further)
        return amplitude * cosine

    def _search(self, value: float, tolerance: float, advance: float, further: float) -> float:
        """Find the phase from all information; return its cosine.

        If the sample contradicts the advance, the other frequency may be right: a sweep has begun
        or ended.
        """
        doubt = _SWEEP_ROUGHNESS * abs(further)
        other = (further, doubt) if 0.0 < doubt < _LOST else None
        cosine, other_was_right = self._estimate.search(value, tolerance, advance, other)
        if other_was_right:
            self._sweeps = not self._sweeps
        return cosine
