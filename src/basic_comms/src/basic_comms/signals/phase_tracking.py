"""Track the phase of a sampled sine, to give the quadrature (cosine) that belongs to each sample.

The fields of a sample are rounded to float32, so a sample confines the phase to an interval, and
from one sample to the next the phase advances by frequency * dt within a small error. Bounded-error
(set-membership) estimation carries the interval forward, cuts it by what the new sample allows and
answers with its middle, the estimate of the smallest worst-case error. Two things follow.

- A single sample leaves a rising and a falling phase open; the tracker carries both until a sample
  contradicts one. Two samples D rad apart pin the quadrature to 2e-7/|sin D| of the amplitude.
- Near a crest, where the sine says little about its phase, the prediction decides by itself.
"""

import math
from typing import List

from basic_comms.signals.phase_intervals import (
    TURN,
    Interval,
    intersect,
    nearest_first,
    phases_of_sine,
)

# Half a unit in the last place of float32, relative.
_ROUNDING = 2.0**-24
# Rounding of time_x and of frequency * time_x in double precision at both ends of a step, relative.
_TIME_ROUNDING = 2.0**-51
# What two samples D rad apart promise of the quadrature: _PAIR_ERROR / |sin D| of the amplitude.
_PAIR_ERROR = 1.9e-7
# Below this half width (rad) an interval is cut along the tangent of the sine, which then leaves
# the sine by less than the least tolerance.
_NARROW = 1e-4
_LEAST_TOLERANCE = 0.5 * _NARROW**2
# A step whose advance is less certain than this (rad) says nothing of the next phase.
_LOST = 1.0
# A phase that samples contradict is still tried on later ones up to this half width (rad).
_FORGET = 1e-3
# Pull towards an input that is no exact sine, per rad of advance: a phase-locked loop that settles
# within a few periods.
_PULL = 0.2
# How far a sweep may be from linear between two samples, relative to what it adds to the advance.
_SWEEP_ROUGHNESS = 1e-3
# A smaller amplitude comes near float32's subnormal numbers, which have no relative precision.
_LEAST_AMPLITUDE = 1e-36


class PhaseTracker:
    """Follow the phase of amplitude * sin(phase) through samples as they come over the wire.

    All arguments must be finite. With zero amplitude or frequency the phase keeps its course. An
    input that is no sine of the stated amplitude and frequency leaves the phase on its course for
    one period and pulls it gently from then on. A sine that jumps is found from two new samples.
    If the advance by the latest frequency is contradicted, the mean frequency of the latest two
    samples is tried, which is that of a sweep.
    """

    __slots__ = (
        "restarts",
        "_time",
        "_frequency",
        "_phase",
        "_half",
        "_open",
        "_contradicted",
        "_sweeps",
    )

    def __init__(self) -> None:
        #: How often time_x repeated itself or ran backwards, which starts the tracking anew.
        self.restarts = 0
        self._time = -math.inf
        self._frequency = 0.0
        self._phase = 0.0
        # Half width of the interval around _phase when one narrow interval is left, else infinite;
        # then _open holds the intervals left open, the one most likely first.
        self._half = math.inf
        self._open: List[Interval] = []
        # Phase passed since samples began to contradict each other, rad.
        self._contradicted = 0.0
        # Whether frequency changes gradually from sample to sample, not at once with a sample.
        self._sweeps = False

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
        if time_x <= self._time:
            self.restarts += 1
            self._time = -math.inf
        step = time_x - self._time
        advance = frequency * step
        slack = _ROUNDING * abs(advance) + _TIME_ROUNDING * abs(frequency * time_x)
        sweep = 0.0
        if frequency != self._frequency:
            sweep = 0.5 * (self._frequency - frequency) * step
            if self._sweeps:
                advance += sweep
                slack += _SWEEP_ROUGHNESS * abs(sweep)
                sweep = -sweep
        else:
            self._sweeps = False
        self._time = time_x
        self._frequency = frequency
        if slack < _LOST:
            phase = math.remainder(self._phase + advance, TURN)
            half = self._half + slack
        else:
            # Nothing known from earlier samples. A generator left alone obeys phase = w t.
            phase = frequency * time_x
            phase = math.remainder(phase, TURN) if abs(phase) < 1e15 else 0.0
            advance = sweep = 0.0
            half = math.inf
            self._open = []

        magnitude = abs(amplitude)
        if magnitude < _LEAST_AMPLITUDE:
            self._phase = phase
            self._half = half
            self._open = [(centre + advance, width + slack) for centre, width in self._open]
            return amplitude * math.cos(phase)
        value = (signal_y - input_offset) / amplitude
        tolerance = _ROUNDING * (abs(value) + abs(signal_y) / magnitude) + _LEAST_TOLERANCE

        if half < _NARROW:
            cosine = math.cos(phase)
            error = value - math.sin(phase)
            spread = half * abs(cosine)
            if abs(error) + spread <= tolerance:
                self._phase = phase
                self._half = half
                return amplitude * cosine
            if abs(error) <= tolerance + spread:
                middle = error / cosine
                reach = tolerance / abs(cosine)
                low = max(-half, middle - reach)
                high = min(half, middle + reach)
                self._phase = phase = phase + 0.5 * (low + high)
                self._half = 0.5 * (high - low)
                return amplitude * math.cos(phase)

        if half < math.inf:
            predicted = [(phase, half)]
        else:
            predicted = [(centre + advance, width + slack) for centre, width in self._open]
        return amplitude * self._search(phase, predicted, value, tolerance, advance, sweep)

    def _search(
        self,
        phase: float,
        predicted: List[Interval],
        value: float,
        tolerance: float,
        advance: float,
        sweep: float,
    ) -> float:
        """Settle on a phase while more than one narrow interval is open; return its cosine."""
        measured = phases_of_sine(value, tolerance)
        left = nearest_first(intersect(predicted, measured) if predicted else measured, phase)
        doubt = _SWEEP_ROUGHNESS * abs(sweep)
        if not left and 0.0 < doubt < _LOST:
            swept = [(centre + sweep, half + doubt) for centre, half in predicted]
            left = nearest_first(intersect(swept, measured), phase + sweep)
            self._sweeps ^= bool(left)
        self._half = math.inf
        if left:
            self._open = left
            self._contradicted = 0.0
            phase, half = left[0]
            if len(left) == 1 and half < _NARROW:
                self._half = half
        else:
            # An outlier, a jump or no such sine: try the old course and a fresh start side by side.
            self._open = [course for course in predicted[:1] if course[1] < _FORGET] + measured
            self._contradicted += abs(advance)
            if self._contradicted > TURN:
                error = min(max(value, -1.0), 1.0) - math.sin(phase)
                phase += _PULL * min(abs(advance), 1.0) * error * math.cos(phase)
        self._phase = phase
        cosine = math.cos(phase)
        if predicted and len(left) > 1:
            # Follow the prediction only as far as the promise holds whichever interval is true.
            ends = [math.cos(centre + side * half) for centre, half in left for side in (-1, 1)]
            promise = _PAIR_ERROR / max(abs(math.sin(advance)), 1e-9)
            middle = 0.5 * (min(ends) + max(ends))
            room = max(0.0, min(ends) + promise - middle)
            cosine = min(max(cosine, middle - room), middle + room)
        return cosine
