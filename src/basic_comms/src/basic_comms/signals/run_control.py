"""Run control: start delay, stops and duration of a signal."""

from typing import NamedTuple, Optional

IDLE = "idle"
RUNNING = "running"
FINISHED = "finished"


class RunStatus(NamedTuple):
    """State of a signal, and its time.

    :ivar state: ``idle``, ``running`` or ``finished``
    :ivar time_x: time for which the signal has run [s]
    """

    state: str
    time_x: float

    def __str__(self) -> str:
        return f"{self.state} {self.time_x:.3f}"


class RunControl:
    """Converter from clock readings to the time of a signal with start delay, stops and duration.

    The signal's time is the time for which it has run. It starts at 0 with the first reading, or
    after the start delay, which counts while the signal is enabled. It is held while the signal is
    stopped, and continues when it is enabled again: phase and sweep continue from there, and
    ``frequency * (time_x[n] - time_x[n-1])`` is the advance across the pause as well. After the
    duration the signal is finished; a longer duration continues it, a reset restarts it. Only a
    reset sets the time back, even if the clock is set back.

    Not thread-safe.

    :param enabled: whether the signal runs without being enabled first
    """

    def __init__(self, enabled: bool = True) -> None:
        self._enabled = enabled
        self._delayed = True
        self._collected = 0.0  # s, up to the reading _since
        self._since: Optional[float] = None  # None while the time is held
        self._latest_reading = float("-inf")
        self._time_x = 0.0

    def enable(self, now: float, enabled: bool) -> None:
        """Stop or continue the signal.

        :param now: reading of the clock [s]
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
        """Set the time back to 0, or restart the delay if it has not elapsed."""
        self._collected = 0.0
        self._since = None

    def at(self, now: float, start_delay: float, duration: float) -> RunStatus:
        """Return the state and the time of the signal for its next sample.

        :param now: reading of the clock [s]
        :param start_delay: delay before the signal starts, >= 0 [s]
        :param duration: time after which the signal is finished [s]; 0 for unlimited
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
            # Not below the time of the last sample, in case the duration was reduced.
            seconds = self._collected = max(duration, self._time_x)
            self._since = None
            state = FINISHED
        else:
            state = RUNNING if self._enabled else IDLE
        self._time_x = seconds
        return RunStatus(state, seconds)

    def _read(self, now: float) -> None:
        """Record a reading of the clock; continue from it if the clock has been set back."""
        if now < self._latest_reading and self._since is not None:
            self._collected = self._seconds(self._latest_reading)
            self._since = now
        self._latest_reading = now

    def _seconds(self, now: float) -> float:
        """Return the time collected up to a reading, which must not be before the last one [s]."""
        if self._since is None:
            return self._collected
        return self._collected + (now - self._since)
