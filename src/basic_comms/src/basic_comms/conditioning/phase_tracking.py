"""Track the phase of a sampled sine, to give the quadrature (cosine) that belongs to each sample.

A message has the amplitude, angular frequency, time and value of a sample. They give how far the
phase went since the previous sample and what the sine was, each with its largest error, as the
fields are rounded to float32; :mod:`basic_comms.conditioning.phase_estimate` does the rest.
"""

import math

from basic_comms.conditioning.phase_estimate import LEAST_TOLERANCE, PhaseEstimate

# Half a unit in the last place of float32, relative.
_ROUNDING = 2.0**-24
# Rounding of time_x and of frequency * time_x in double precision at both ends of a step, relative.
_TIME_ROUNDING = 2.0**-51
# A step whose advance is less certain than this (rad) says nothing of the next phase.
_LOST = 1.0
# How far a sweep may be from linear between two samples, relative to what it adds to the advance.
_SWEEP_ROUGHNESS = 1e-3
# A smaller amplitude comes near float32's subnormal numbers, which have no relative precision.
_LEAST_AMPLITUDE = 1e-36


class PhaseTracker:
    """Follow the phase of amplitude * sin(phase) through samples as they come over the wire.

    All arguments must be finite. With zero amplitude or frequency the phase keeps its course. An
    input that is not a sine of the stated amplitude and frequency leaves the phase on its course
    for one period and pulls it gently from then on. A sine that jumps is found from two new
    samples.
    If the advance by the latest frequency is contradicted, the mean frequency of the latest two
    samples is tried, which is that of a sweep.
    """

    __slots__ = ("restarts", "_time", "_frequency", "_sweeps", "_estimate")

    def __init__(self) -> None:
        #: How often time_x repeated itself or ran backwards, which restarts the tracking.
        self.restarts = 0
        # Of the previous sample, s and rad/s. Before the first it is so long ago that nothing
        # follows from it.
        self._time = -math.inf
        self._frequency = 0.0
        # Whether frequency changes gradually from sample to sample, not at once with a sample.
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
        """Take in one sample.

        :param amplitude: peak value of the sine, in the unit of signal_y
        :param frequency: angular frequency since the previous sample, rad/s
        :param time_x: time of the sample, s
        :param signal_y: value of the sine, swinging around input_offset
        :param input_offset: mean value of signal_y
        :returns: amplitude * cos(phase) at this sample
        """
        # In one piece up to the estimate: each call made here costs 7 % of what all of it takes.
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
            # By how much the mean frequency would take the phase further than the latest one.
            further = 0.5 * (self._frequency - frequency) * step
            self._frequency = frequency
            if self._sweeps:
                advance += further
                slack += _SWEEP_ROUGHNESS * abs(further)
                further = -further
        if not slack < _LOST:  # it may be NaN
            # Nothing is known from earlier samples. A generator left alone obeys phase = w t.
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
        """Find the phase by all that is known of it; return its cosine.

        Where the sample contradicts the advance, the other frequency may have been the right one:
        then a sweep has begun, or ended.
        """
        doubt = _SWEEP_ROUGHNESS * abs(further)
        other = (further, doubt) if 0.0 < doubt < _LOST else None
        cosine, other_was_right = self._estimate.search(value, tolerance, advance, other)
        if other_was_right:
            self._sweeps = not self._sweeps
        return cosine
