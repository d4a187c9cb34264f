"""Detection of late samples, which have no stamp, only the signal's own time.

A sample contains the signal's time at its creation. The lag, the receiver's clock minus that time,
is a constant of arbitrary value. Samples that a broken connection has delayed have a larger lag, by
their lateness; afterwards it falls back.
"""

import math
from typing import Any, Sequence

#: From this lateness on samples count as late [s]: more than a generator catches up when busy.
LATE_S = 1.0
#: A lag that has lasted this long is the new normal lag [s]: the signal was stopped meanwhile.
SETTLED_S = 5.0


class LatenessMonitor:
    """Monitor of a stream of samples for late ones.

    The lag may change slowly, for example when a bag is played at half speed; it is compared with
    that of the preceding samples. A signal whose time stops or restarts has a new lag.

    A simulated clock may jump, and the signal's time with it. If the signal shows the jump first,
    the lag falls, and soon rises to its former value. That is not lateness.
    """

    def __init__(self) -> None:
        #: Whether the latest samples were late.
        self.is_late = False
        #: Number of samples in the current or last series of late ones.
        self.count = 0
        #: Largest lateness in that series [s].
        self.worst = 0.0
        self._lag = -math.inf
        self._time = math.inf
        self._since = 0.0
        # Lag before the signal jumped ahead of the clock, and until when it is kept, in its time
        # [s].
        self._lag_before, self._before_until = -math.inf, -math.inf

    def update(self, now: float, samples: Sequence[Any]) -> bool:
        """Process samples that were received together.

        :param now: reception time, on a clock that runs like the signal's [s]; 0 is a simulated
            clock before its first message
        :param samples: the samples, oldest first, each with its time ``time_x`` [s]
        :returns: whether samples have become late, or ceased to be late
        """
        first, latest = samples[0].time_x, samples[-1].time_x
        if not math.isfinite(first + latest):
            return False  # not a signal
        if now == 0.0:
            return False  # a simulated clock before its first message: the lag is undefined
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
        """Return whether the lag is as it was before the signal jumped ahead of the clock."""
        lag = now - time_x
        return time_x <= self._before_until and abs(lag - self._lag_before) < LATE_S
