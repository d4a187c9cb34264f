"""Gaps between the samples of the signal generator."""

from typing import List, Sequence

from helpers.machine_lag import Lag

#: A generator that a busy machine holds up for longer skips the samples of that time [s].
_CATCH_UP_S = 0.5


def gaps(times: Sequence[float], rate: float, lag: Lag) -> List[float]:
    """Return the steps between samples that miss others, unless the machine explains them [s].

    :param times: times of the samples, in order [s]
    :param rate: rate of the generator [Hz]
    :param lag: delay of the generator's process meanwhile
    """
    steps = [later - one for one, later in zip(times, times[1:])]
    missing = [step for step in steps if round(rate * step, 3) != 1.0]
    # A generator that something else held up has not waited for a processor that long.
    return [step for step in missing if not _CATCH_UP_S < step < 2.0 * lag.longest]
