"""Estimator of the phase of a sine, from its samples and the advance between them.

A sample is exact only to rounding, so it confines the phase to an interval, and the advance from
one sample to the next is known within a small error. Bounded-error (set-membership) estimation
propagates the interval, intersects it with that of the new sample and returns its middle, the
estimate with the smallest worst-case error (Milanese and Vicino, "Optimal estimation theory for
dynamic systems with set membership uncertainty: an overview", Automatica 27(6), 1991). Two
consequences:

- A single sample leaves a rising and a falling phase open; the estimate carries both until a sample
  contradicts one. Two samples D rad apart pin the quadrature to 2e-7/|sin D| of the amplitude.
- Near a crest, where the sine contains little information on its phase, the prediction decides.
"""

import math
from typing import List, Optional, Tuple

from basic_comms.conditioning.phase_intervals import (
    TURN,
    Interval,
    intersect,
    nearest_first,
    phases_of_sine,
)

# Guaranteed error of the quadrature from two samples D rad apart: _PAIR_ERROR / |sin D|, relative.
_PAIR_ERROR = 1.9e-7
# Below this half width (rad) an interval is cut along the tangent of the sine.
_NARROW = 1e-4
#: Largest deviation of the tangent from the sine there: the least tolerance of a measured value.
LEAST_TOLERANCE = 0.5 * _NARROW**2
# A phase that samples contradict is still tried on later ones up to this half width [rad].
_FORGET = 1e-3
# Pull towards an input that is not an exact sine, per rad of advance: a phase-locked loop that
# settles within a few periods.
_PULL = 0.2
# A larger phase [rad] has no accuracy within a turn.
_LARGEST_PHASE = 1e15


class PhaseEstimate:
    """Estimate of the phase of a unit sine.

    Each sample is passed to :meth:`follow` and, if that returns None, to :meth:`search`. An input
    that is not a unit sine is ignored for one period, and pulls the phase gently from then on.
    """

    __slots__ = ("phase", "_half", "_open", "_contradicted")

    def __init__(self) -> None:
        #: The most likely phase [rad].
        self.phase = 0.0
        # Half width of the interval around phase, if it is the only one and was narrow at the last
        # sample; else infinite, and _open holds all possible intervals, the most likely first.
        self._half = math.inf
        self._open: List[Interval] = []
        # Phase advance since samples began to contradict each other [rad].
        self._contradicted = 0.0

    def start(self, phase: float) -> None:
        """Restart from a guess.

        :param phase: the guess, of any size [rad]
        """
        self.phase = math.remainder(phase, TURN) if abs(phase) < _LARGEST_PHASE else 0.0
        self._half = math.inf
        self._open = []

    def advance(self, angle: float, slack: float) -> None:
        """Propagate the estimate without a sample.

        :param angle: advance of the phase [rad]
        :param slack: largest error of angle [rad]
        """
        self.phase = math.remainder(self.phase + angle, TURN)
        self._half += slack
        if self._open:
            self._open = [(centre + angle, half + slack) for centre, half in self._open]

    def follow(self, angle: float, slack: float, value: float, tolerance: float) -> Optional[float]:
        """Propagate the estimate to a sample and, in the usual case, process the sample.

        :param angle: advance of the phase since the previous sample [rad]
        :param slack: largest error of angle [rad]
        :param value: measured value of the sine, 1 at the crest
        :param tolerance: largest error of the value, at least LEAST_TOLERANCE
        :returns: cosine of the phase; None if the sample is still to be processed by :meth:`search`
        """
        half = self._half + slack
        if half >= _NARROW:
            self.advance(angle, slack)
            return None
        self._half = half
        self.phase = phase = math.remainder(self.phase + angle, TURN)
        cosine = math.cos(phase)
        error = value - math.sin(phase)
        distance = abs(error)
        spread = half * abs(cosine)
        if distance + spread <= tolerance:
            return cosine
        if distance > tolerance + spread:
            return None
        middle = error / cosine
        reach = tolerance / abs(cosine)
        low = max(-half, middle - reach)
        high = min(half, middle + reach)
        self.phase = phase + 0.5 * (low + high)
        self._half = 0.5 * (high - low)
        return math.cos(self.phase)

    def search(
        self, value: float, tolerance: float, angle: float, other: Optional[Interval]
    ) -> Tuple[float, bool]:
        """Process a sample with all possible intervals, if :meth:`follow` could not.

        :param value: as for :meth:`follow`
        :param tolerance: as for :meth:`follow`
        :param angle: as for :meth:`follow`; 0 after :meth:`start`
        :param other: further advance of the phase to try if the sample contradicts angle
        :returns: cosine of the phase; whether it has advanced further by ``other``
        """
        predicted = [(self.phase, self._half)] if self._half < math.inf else self._open
        measured = phases_of_sine(value, tolerance)
        guess = self.phase
        left = intersect(predicted, measured) if predicted else measured
        other_was_right = False
        if not left and other is not None:
            shift, doubt = other
            guess += shift
            left = intersect(
                [(centre + shift, half + doubt) for centre, half in predicted], measured
            )
            other_was_right = bool(left)
        if left:
            self._go_on_with(nearest_first(left, guess))
        else:
            self._go_on_against(predicted, measured, value, angle)
        cosine = math.cos(self.phase)
        if predicted and len(left) > 1:
            cosine = _within_promise(cosine, left, angle)
        return cosine, other_was_right

    def _go_on_with(self, left: List[Interval]) -> None:
        """Keep the remaining intervals, the most likely first."""
        self._contradicted = 0.0
        self.phase, half = left[0]
        is_usual = len(left) == 1 and half < _NARROW
        self._half = half if is_usual else math.inf
        self._open = [] if is_usual else left

    def _go_on_against(
        self, predicted: List[Interval], measured: List[Interval], value: float, angle: float
    ) -> None:
        """Continue after an outlier or a jump, or with an input that is not such a sine."""
        # The old course and a fresh start are tried side by side.
        self._open = [course for course in predicted[:1] if course[1] < _FORGET] + measured
        self._half = math.inf
        self._contradicted += abs(angle)
        if self._contradicted > TURN:
            error = min(max(value, -1.0), 1.0) - math.sin(self.phase)
            self.phase += _PULL * min(abs(angle), 1.0) * error * math.cos(self.phase)


def _within_promise(cosine: float, left: List[Interval], angle: float) -> float:
    """Follow the prediction only as far as the error bound holds, whichever interval is true.

    :param cosine: cosine of the most likely phase
    :param left: remaining intervals
    :param angle: advance of the phase since the previous sample [rad]
    :returns: the nearest cosine within the bound
    """
    ends = [math.cos(centre + side * half) for centre, half in left for side in (-1, 1)]
    promise = _PAIR_ERROR / max(abs(math.sin(angle)), 1e-9)
    middle = 0.5 * (min(ends) + max(ends))
    room = max(0.0, min(ends) + promise - middle)
    return min(max(cosine, middle - room), middle + room)
