"""The time in which messages could arrive: it stands still with /clock, and while we do."""

from typing import Optional

#: A longer step of the clock is a jump, s: no time has passed.
_JUMP_S = 10.0


class AwakeClock:
    """Counts the time that may be held against robots.

    A pause of simulated time does not count, and neither does a jump of it. Nor does the time in
    which this process was stopped, or got no processor: robots' messages wait to be read then. A
    reading that is more than twice too late counts as much as one in time.

    :param interval_s: how often it is read at least, s

    :ivar time: the time so far, s
    """

    def __init__(self, interval_s: float) -> None:
        self.time = 0.0
        self._interval_s = interval_s
        self._now: Optional[float] = None
        self._machine = self._moved_at = 0.0

    def read(self, now: float, machine: float) -> float:
        """Return the time; to be called now and then, and with each message.

        :param now: ROS time where it is simulated, else as ``machine``, s
        :param machine: the machine's monotonic clock, s
        """
        if self._now is None:
            self._moved_at = machine
        else:
            step, away = now - self._now, machine - self._machine
            if step:
                self._moved_at = machine
            if away > 2.0 * self._interval_s:
                step *= self._interval_s / away
            if 0.0 < step <= _JUMP_S:
                self.time += step
        self._now, self._machine = now, machine
        return self.time

    @property
    def still_s(self) -> float:
        """For how long the clock has stood still at the last reading, s of the machine's clock."""
        return self._machine - self._moved_at
