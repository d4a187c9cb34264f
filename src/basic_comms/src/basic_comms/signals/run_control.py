"""Run control: when a signal runs, and for how long it has."""

from typing import NamedTuple, Optional

IDLE = "idle"
RUNNING = "running"
FINISHED = "finished"


class RunStatus(NamedTuple):
    """Whether a signal runs, and its time.

    :ivar state: ``idle``, ``running`` or ``finished``
    :ivar time_x: time for which the signal has run, s
    """

    state: str
    time_x: float

    def __str__(self) -> str:
        return f"{self.state} {self.time_x:.3f}"


class RunControl:
    """Turn readings of a clock into the time of a signal that can be delayed, stopped and limited.

    The signal's time is the time for which it has run. It starts at 0 with the first reading, or
    when the start delay is over, which counts while the signal is enabled. It stands still while
    the signal is stopped and goes on from there when it is enabled again: phase and sweep go on
    where they were, and ``frequency * (time_x[n] - time_x[n-1])`` is the advance across the pause
    as well. At the duration the signal is finished; a longer duration lets it go on, a reset lets
    it start again. Only a reset takes the time back, also if the clock is set back.

    Not safe for several threads at once.

    :param enabled: whether the signal runs without being enabled first
    """

    def __init__(self, enabled: bool = True) -> None:
        self._enabled = enabled
        self._delayed = True
        self._collected = 0.0  # s, up to the reading _since
        self._since: Optional[float] = None  # None while the time stands still
        self._latest_reading = float("-inf")
        self._time_x = 0.0

    def enable(self, now: float, enabled: bool) -> None:
        """Stop the signal or let it go on.

        :param now: reading of the clock, s
        :param enabled: whether the signal is to run
        """
        if enabled == self._enabled:
            return
        self._read(now)
        self._enabled = enabled
        if enabled:
            self._since = now
        else:
            self._collected = self._seconds(now)
            self._since = None

    def reset(self) -> None:
        """Take the time back to 0, or start the delay again if it is not over."""
        self._collected = 0.0
        self._since = None

    def at(self, now: float, start_delay: float, duration: float) -> RunStatus:
        """Return the state and the time of the signal for its next sample.

        :param now: reading of the clock, s
        :param start_delay: time to wait before the signal starts, s, >= 0
        :param duration: time after which the signal is finished, s; 0 for never
        :returns: state and time of the signal
        """
        self._read(now)
        if self._enabled and self._since is None:
            self._since = now
        seconds = self._seconds(now)
        if self._delayed:
            if not self._enabled or seconds < start_delay:
                return RunStatus(IDLE, 0.0)
            self._delayed = False
            seconds -= start_delay
            self._collected, self._since = seconds, now
        if 0.0 < duration <= seconds:
            # Not below the time of the last sample, should the duration have become shorter.
            seconds = self._collected = max(duration, self._time_x)
            self._since = None
            state = FINISHED
        else:
            state = RUNNING if self._enabled else IDLE
        self._time_x = seconds
        return RunStatus(state, seconds)

    def _read(self, now: float) -> None:
        """Record a reading of the clock; count on from it if the clock has been set back."""
        if now < self._latest_reading and self._since is not None:
            self._collected = self._seconds(self._latest_reading)
            self._since = now
        self._latest_reading = now

    def _seconds(self, now: float) -> float:
        """Return the time collected at a reading that is not before the one last noted, s."""
        if self._since is None:
            return self._collected
        return self._collected + (now - self._since)
