"""How time passes while a controller is judged."""

import time
from typing import List, Optional, Protocol

from pid_control.runner.process_watch import ProcessWatch

#: How long the simulated clock stands still at least, by the machine's clock, s; and at least which
#: part of what the scenario took so far: on a busy machine that is long, and what goes by its clock
#: counts on all the time.
_STANDSTILL_S, _STANDSTILL_SHARE = 0.25, 0.5
#: Longest wait for a controller to have nothing to do, s: a machine may be busy.
_LONGEST_S = 2.0
#: Pause between two looks while the clock stands still, s.
_LOOK_S = 0.002


class Clock(Protocol):
    """Waits for the controller."""

    def start(self) -> None:
        """Begin to count the time, at 0."""

    def wait(self, until: float) -> bool:
        """Wait until the next moment is due.

        :param until: that moment, s
        :returns: whether the controller has come to rest
        """

    def pause(self) -> Optional[float]:
        """Let no time pass for a while, if that can be.

        :returns: the share of it in which the controller had nothing to do; None if it cannot be
        """


class SimulatedClock:
    """A simulated clock: time passes when the controller has nothing left to do.

    :param watch: the controller's processes
    """

    def __init__(self, watch: ProcessWatch) -> None:
        self._watch = watch
        self._began = 0.0

    def start(self) -> None:
        """Begin to count the machine's time."""
        self._began = time.monotonic()

    def wait(self, until: float) -> bool:
        """Wait until the controller has nothing left to do, but not for ever."""
        return self._watch.wait_idle(_LONGEST_S)

    def pause(self) -> Optional[float]:
        """See how often the controller has nothing to do, where there is nothing."""
        rests: List[bool] = []
        now = time.monotonic()
        end = now + max(_STANDSTILL_S, _STANDSTILL_SHARE * (now - self._began))
        while time.monotonic() < end:
            rests.append(self._watch.is_idle())
            time.sleep(_LOOK_S)
        return sum(rests) / len(rests)


class WallClock:
    """The machine's clock.

    :ivar latest: how late this process was at most, s
    """

    def __init__(self) -> None:
        self._began = 0.0
        self.latest = 0.0

    def start(self) -> None:
        """Begin to count the time, at 0."""
        self._began = time.monotonic()

    def wait(self, until: float) -> bool:
        """Sleep until a moment."""
        left = self._began + until - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        self.latest = max(self.latest, -left)
        return True

    def pause(self) -> Optional[float]:
        """Nobody can stop this clock."""
        return None
