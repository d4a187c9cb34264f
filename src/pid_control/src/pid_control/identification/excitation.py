"""Excitation signal for an identification experiment: a slow ramp, then steps."""

from typing import List, NamedTuple, Optional

#: The ramp that finds the dead zone: share of the duration, end as a share of the largest input,
#: and number of steps. A larger dead zone is found by the steps, less accurately.
_RAMP_SHARE, _RAMP_END, _RAMP_STEPS = 0.4, 0.4, 400
#: The following steps, as shares of the largest input or, if negative, of the least input: up and
#: down, to the output's limit and below it.
_STEPS = (0.0, 1.0, 0.0, 0.5, 0.8, 0.3, -1.0, 0.6, -0.5, 0.0)
#: Longest progress of the experiment from one input to the next [s].
_LONGEST_STEP_S = 0.1


class InputChange(NamedTuple):
    """A change of the input.

    :ivar time: time of the change [s]
    :ivar value: the input from then on
    """

    time: float
    value: float


def excitation(least: float, largest: float, seconds: float) -> List[InputChange]:
    """Return the changes of the input; the last value is 0.

    :param least: the least input, <= 0
    :param largest: the largest input, > 0
    :param seconds: duration [s]
    """
    ramp = seconds * _RAMP_SHARE
    changes = [
        InputChange(ramp * number / _RAMP_STEPS, largest * _RAMP_END * number / _RAMP_STEPS)
        for number in range(_RAMP_STEPS)
    ]
    hold = (seconds - ramp) / len(_STEPS)
    for number, share in enumerate(_STEPS):
        value = share * largest if share >= 0.0 else -share * least
        changes.append(InputChange(ramp + number * hold, value))
    return changes


class Progress:
    """Progress of an experiment, and its current input.

    If the machine stalls, the experiment takes longer instead of skipping a step.

    :param changes: changes of the input, the first at 0 s
    :param seconds: duration [s]
    """

    def __init__(self, changes: List[InputChange], seconds: float) -> None:
        self._changes, self._seconds = changes, seconds
        self._done = 0.0
        self._asked_at: Optional[float] = None

    def input_at(self, time: float) -> Optional[float]:
        """Return the current input, or None after the end of the experiment.

        :param time: now, by any clock [s]
        """
        if self._asked_at is not None:
            self._done += min(time - self._asked_at, _LONGEST_STEP_S)
        self._asked_at = time
        if self._done > self._seconds:
            return None
        return [change.value for change in self._changes if change.time <= self._done][-1]
