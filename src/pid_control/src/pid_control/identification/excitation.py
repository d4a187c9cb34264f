"""What to give a plant so that its record tells all of it: a slow ramp, then steps."""

from typing import List, NamedTuple, Optional

#: The ramp that finds the dead zone: how much of the time it takes, how far it goes and in how many
#: steps. A larger dead zone is found by the steps, less well.
_RAMP_SHARE, _RAMP_END, _RAMP_STEPS = 0.4, 0.4, 400
#: The steps that follow, in shares of the largest input; below 0, of the least one where that is
#: below 0. They go up and down, to the limit and to where it is not met.
_STEPS = (0.0, 1.0, 0.0, 0.5, 0.8, 0.3, -1.0, 0.6, -0.5, 0.0)
#: How far an experiment goes on at most from one input to the next, s.
_LONGEST_STEP_S = 0.1


class Change(NamedTuple):
    """A change of the input.

    :ivar time: when, s
    :ivar value: what it is from then on
    """

    time: float
    value: float


def excitation(least: float, largest: float, seconds: float) -> List[Change]:
    """Return the inputs to give, of which the last one is 0.

    :param least: the least input, <= 0
    :param largest: the largest input, > 0
    :param seconds: how long it takes, s
    """
    ramp = seconds * _RAMP_SHARE
    changes = [
        Change(ramp * number / _RAMP_STEPS, largest * _RAMP_END * number / _RAMP_STEPS)
        for number in range(_RAMP_STEPS)
    ]
    hold = (seconds - ramp) / len(_STEPS)
    for number, share in enumerate(_STEPS):
        value = share * largest if share >= 0.0 else -share * least
        changes.append(Change(ramp + number * hold, value))
    return changes


class Progress:
    """How far an experiment is: which input is due.

    Where the machine stands still for a moment, the experiment becomes longer and skips no step.

    :param changes: of the input, the first at 0 s
    :param seconds: how long it takes, s
    """

    def __init__(self, changes: List[Change], seconds: float) -> None:
        self._changes, self._seconds = changes, seconds
        self._done = 0.0
        self._asked_at: Optional[float] = None

    def input_at(self, time: float) -> Optional[float]:
        """Return the input that is due, or None when the experiment is at its end.

        :param time: now, s, by a clock that starts anywhere
        """
        if self._asked_at is not None:
            self._done += min(time - self._asked_at, _LONGEST_STEP_S)
        self._asked_at = time
        if self._done > self._seconds:
            return None
        return [change.value for change in self._changes if change.time <= self._done][-1]
