"""Phase accumulator: the phase of an oscillator whose frequency may change at any sample."""

#: Advance [rad] at which the anchor moves. Rounding then changes
#: ``phase + frequency * (time - anchor)`` by no more than 1.5 units in the last place of 1024.
_LONGEST_ADVANCE = 1024.0

#: Anchor phases are whole multiples of 2**-128 rad, so moving an anchor adds 3e-39 rad of error.
_FRACTION_BITS = 128
_ONE_RADIAN = 1 << _FRACTION_BITS
_TWO_PI = (2 * 3_14159265358979323846264338327950288419716939937510 << _FRACTION_BITS) // 10**50


class PhaseAccumulator:
    """Phase accumulator without phase jumps at changes of frequency.

    From sample n-1 to sample n the phase advances with the frequency of sample n::

        phase[n] = phase[n-1] + frequency[n] * (time[n] - time[n-1])

    with phase 0 at time 0. Frequency 0 holds the phase, a negative one runs it backwards. While the
    frequency has not changed since the start, the phase is ``frequency * time``.

    Summing one product per sample would accumulate rounding errors. So the sum is kept relative to
    an anchor, a past (time, phase), which moves only when the frequency changes or the phase has
    advanced far, and then in exact integer arithmetic modulo 2 pi. The error stays below 1e-12 rad
    for any number of samples and changes.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Return to phase 0 at time 0."""
        self._time = 0.0
        self._frequency = 0.0
        self._anchor_time = 0.0
        self._anchor_phase = 0.0
        self._exact_phase = 0

    def advance(self, time: float, frequency: float) -> float:
        """Return the phase of the next sample.

        :param time: time of the sample [s]
        :param frequency: angular frequency since the sample before [rad/s]
        :returns: phase, modulo whole turns [rad]
        """
        if frequency != self._frequency:
            self._move_anchor(self._time)
            self._frequency = frequency
        self._time = time
        advance = frequency * (time - self._anchor_time)
        if not -_LONGEST_ADVANCE < advance < _LONGEST_ADVANCE:
            self._move_anchor(time)
            return self._anchor_phase
        return self._anchor_phase + advance

    def _move_anchor(self, time: float) -> None:
        """Move the anchor along the current frequency to a given time [s], without rounding."""
        frequency, frequency_scale = self._frequency.as_integer_ratio()
        new, new_scale = time.as_integer_ratio()
        old, old_scale = self._anchor_time.as_integer_ratio()
        advance = frequency * (new * old_scale - old * new_scale) * _ONE_RADIAN
        advance //= frequency_scale * new_scale * old_scale
        self._exact_phase = (self._exact_phase + advance) % _TWO_PI
        self._anchor_phase = self._exact_phase / _ONE_RADIAN
        self._anchor_time = time
