"""Clocks that pace a scenario: simulated (advanced when the controller is idle), or wall clock."""

import time
from statistics import fmean
from typing import Callable, List, Optional, Protocol

from pid_control.judging.record import Pause
from pid_control.programs.process_watch import ProcessWatch

#: Shortest pause of the simulated clock: by the machine's clock [s], and as a share of the time
#: that the scenario took so far. On a busy machine a loop by the machine's clock needs that long.
_STANDSTILL_S, _STANDSTILL_SHARE = 0.25, 0.5
#: Longest wait for an idle controller [s]: a machine may be busy.
_LONGEST_S = 2.0
#: roscpp's loops, while they sleep, look at a simulated clock once in 1 ms. A step waits as long.
_ROSCPP, _ROSCPP_POLLS_S = "libroscpp.so", 0.0013
#: Interval of the checks during a pause [s].
_CHECK_S = 0.002


class Clock(Protocol):
    """Clock of a scenario."""

    def start(self) -> None:
        """Start the clock at 0."""

    def wait(self, until: float) -> bool:
        """Wait until the next step.

        :param until: time of the next step [s]
        :returns: True if the controller is idle
        """

    def pause(self, time_of: float, pop_answers: Callable[[], int]) -> Optional[Pause]:
        """Pause the clock, if possible: each time for longer than before.

        :param time_of: time in the scenario [s]
        :param pop_answers: returns the number of answers since its previous call
        """


class SimulatedClock:
    """Simulated clock that advances when the controller is idle.

    :param watch: processes of the controller
    """

    def __init__(self, watch: ProcessWatch) -> None:
        self._watch = watch
        self._began = self._paused = 0.0
        self._is_polled = False

    def start(self) -> None:
        """Start the clock."""
        self._began = time.monotonic()
        self._is_polled = self._watch.has_library(_ROSCPP)

    def wait(self, until: float) -> bool:
        """Wait until the controller is idle, with a timeout."""
        if self._is_polled:
            time.sleep(_ROSCPP_POLLS_S)
        return self._watch.wait_idle(_LONGEST_S)

    def pause(self, time_of: float, pop_answers: Callable[[], int]) -> Optional[Pause]:
        """Pause the clock, twice as long as before."""
        rests: List[bool] = []
        begin = time.monotonic()
        taken = begin - self._began
        length = 2.0 * self._paused or max(_STANDSTILL_S, _STANDSTILL_SHARE * taken)
        has_popped, now = False, begin
        self._watch.has_run()
        while now < begin + length:
            is_idle, has_run = self._watch.is_idle(), self._watch.has_run()
            if is_idle or has_run:  # a thread that waits for a processor tells nothing
                rests.append(is_idle)
            time.sleep(_CHECK_S)
            now = time.monotonic()
            if not has_popped and now > begin + 0.5 * length:
                pop_answers()  # answers that were late
                has_popped = True
        self._paused = length
        return Pause(time_of, now - begin, fmean(rests) if rests else 1.0, pop_answers())


class WallClock:
    """Wall clock, for scenarios in real time.

    :ivar latest: largest delay of this process so far [s]
    """

    def __init__(self) -> None:
        self._began = 0.0
        self.latest = 0.0

    def start(self) -> None:
        """Start the clock at 0."""
        self._began = time.monotonic()

    def wait(self, until: float) -> bool:
        """Sleep until the next step."""
        left = self._began + until - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        self.latest = max(self.latest, -left)
        return True

    def pause(self, time_of: float, pop_answers: Callable[[], int]) -> Optional[Pause]:
        """Return None: this clock cannot be paused."""
        return None
