"""Recognise samples that come late, though they carry no stamp, only a time of their own.

A sample says how far its signal had run when it was made. The lag, the receiver's clock minus that
time, is a constant whose value means nothing. Samples that a broken link has held back have a
larger one, by as much as they are late; after them it falls back.
"""

import math
from typing import Any, Sequence

#: from here on samples count as late, s: more than a generator catches up after a busy moment
LATE_S = 1.0
#: a lag that has lasted so long is the new normal one, s: the signal was stopped meanwhile
SETTLED_S = 5.0


class LatenessMonitor:
    """Watches a stream of samples for late ones.

    The lag may change slowly, as when a bag is played at half its speed; it is compared with that
    of the samples just before. A signal whose time stands still or restarts has a new lag.

    A simulated clock may jump, and the signal's time with it. The signal may show the
    jump before the clock does: then the lag falls, and soon rises to just what it was before.
    That is not lateness either.
    """

    def __init__(self) -> None:
        #: whether the latest samples were late
        self.is_late = False
        #: samples that came late, of those coming in now or else the last time
        self.count = 0
        #: how late the latest of them was at most, s
        self.worst = 0.0
        self._lag = -math.inf
        self._time = math.inf
        self._since = 0.0
        # The lag before the signal jumped ahead of the clock, until when in its time, s.
        self._lag_before, self._before_until = -math.inf, -math.inf

    def update(self, now: float, samples: Sequence[Any]) -> bool:
        """Take in samples that came together.

        :param now: when they came, on a clock that runs as the signal does, s; 0 is what a
            simulated clock shows until its first message
        :param samples: the samples, the oldest first; each has its time in s as ``time_x``
        :returns: whether samples have begun or ceased to be late
        """
        first, latest = samples[0].time_x, samples[-1].time_x
        if not math.isfinite(first + latest):
            return False  # not a signal
        if now == 0.0:
            return False  # a simulated clock before its first message: no lag to go by
        lateness = now - first - self._lag if first > self._time else 0.0
        if lateness >= LATE_S and self._clock_has_followed(now, first):
            lateness = 0.0
        self._time = latest
        if lateness < LATE_S or (self.is_late and now - self._since > SETTLED_S):
            was_late, self.is_late = self.is_late, False
            lag = now - latest
            if self._lag - lag >= LATE_S:  # a jump ahead: the clock may follow
                self._lag_before, self._before_until = self._lag, latest + SETTLED_S
            self._lag = lag
            return was_late
        begins = not self.is_late
        if begins:
            self.is_late = True
            self._since = now
            self.count, self.worst = 0, 0.0
        self.worst = max(self.worst, lateness)
        limit = now - self._lag - LATE_S
        self.count += sum(sample.time_x <= limit for sample in samples)
        return begins

    def _clock_has_followed(self, now: float, time_x: float) -> bool:
        """Tell whether the lag is as it was before the signal jumped ahead of the clock."""
        lag = now - time_x
        return time_x <= self._before_until and abs(lag - self._lag_before) < LATE_S
