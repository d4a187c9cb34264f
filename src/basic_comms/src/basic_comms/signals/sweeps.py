"""Frequency sweep (chirp): how the frequency of an oscillator changes with time."""

import math
from typing import NamedTuple


class Chirp(NamedTuple):
    """Sweep from one frequency to another, once or repeatedly.

    The phase of a chirp is the integral of its frequency. So a sweep is described by its frequency
    at a time and by the mean over an interval; a phase accumulator that is fed with the means gets
    exactly the integral. The laws, with ``u = elapsed / duration`` from 0 to 1, are those of
    ``scipy.signal.chirp``:

    * linear: ``first + (last - first) * u``
    * logarithmic: ``first * (last / first) ** u``

    A single sweep stays at its last frequency afterwards; a repeated one restarts at its first.

    :ivar first: frequency at the start of the sweep [rad/s]
    :ivar last: frequency at the end of the sweep [rad/s]
    :ivar duration: length of the sweep, s, > 0
    :ivar logarithmic: the logarithmic law; both frequencies must be positive and differ
    :ivar repeat: start again after each sweep
    """

    first: float
    last: float
    duration: float
    logarithmic: bool
    repeat: bool

    def frequency(self, elapsed: float) -> float:
        """Return the frequency at a time.

        :param elapsed: time since the start of the first sweep [s]
        :returns: instantaneous angular frequency [rad/s]
        """
        if self.repeat:
            elapsed %= self.duration
        elif elapsed >= self.duration:
            return self.last
        part = elapsed / self.duration
        if self.logarithmic:
            return self.first * math.exp(part * math.log(self.last / self.first))
        return self.first + (self.last - self.first) * part

    def mean_frequency(self, since: float, until: float) -> float:
        """Return the mean of the frequency between two times.

        :param since: start of the interval, s since the start of the first sweep
        :param until: end of the interval, likewise
        :returns: mean angular frequency, rad/s; for an empty interval the frequency at that time
        """
        if since == until:
            return self.frequency(until)
        advance = self._repeated(since, until) if self.repeat else self._once(since, until)
        return advance / (until - since)

    def _once(self, since: float, until: float) -> float:
        """Return the phase advance, rad, of a single sweep and the steady oscillation after it."""
        end = self.duration
        steady = max(until, end) - max(since, end)
        return self._sweep(min(since, end), min(until, end)) + self.last * steady

    def _repeated(self, since: float, until: float) -> float:
        """Return the phase advance, rad, of repeated sweeps."""
        since_sweep, since = divmod(since, self.duration)
        until_sweep, until = divmod(until, self.duration)
        if since_sweep == until_sweep:
            return self._sweep(since, until)
        whole = (until_sweep - since_sweep - 1.0) * self._sweep(0.0, self.duration)
        return self._sweep(since, self.duration) + whole + self._sweep(0.0, until)

    def _sweep(self, since: float, until: float) -> float:
        """Return the phase advance between two times within one sweep [rad].

        Each formula avoids the cancellation of a difference between two total phases.
        """
        if self.logarithmic:
            rate = math.log(self.last / self.first) / self.duration
            return self.first * math.exp(rate * since) * math.expm1(rate * (until - since)) / rate
        middle = (since + until) / (2.0 * self.duration)
        return (self.first + (self.last - self.first) * middle) * (until - since)
