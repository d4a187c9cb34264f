"""Clock of the time in which messages could arrive: it stops with /clock, and with this process."""

from typing import Optional

#: A larger step of the clock is a jump [s]: no time has passed.
_JUMP_S = 10.0


class AwakeClock:
    """Clock of the time for which silence of a robot counts.

    A pause or a jump of simulated time does not count. Nor does time in which this process was
    suspended or got no CPU: robots' messages are then waiting to be read. A reading that is more
    than twice too late counts like one in time.

    :param interval_s: longest interval between readings [s]

    :ivar time: the time so far [s]
    """

    def __init__(self, interval_s: float) -> None:
        self.time = 0.0
        self._interval_s = interval_s
        self._now: Optional[float] = None
        self._machine = self._moved_at = 0.0

    def read(self, now: float, machine: float) -> float:
        """Return the time; to be called regularly, and with each message.

        :param now: ROS time if it is simulated, else as ``machine`` [s]
        :param machine: the machine's monotonic clock [s]
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
        """Time for which the clock had stopped at the last reading, by the machine's clock [s]."""
        return self._machine - self._moved_at
