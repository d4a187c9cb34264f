"""Detection of nodes that use the wall clock: their values change while /clock is paused."""

import bisect
import itertools
from typing import List, Optional, Sequence, Tuple

from pid_control.signal_judging.channels import Channel

#: Changes between two messages that count as usual: this share of them, times a factor.
_USUAL, _FACTOR = 0.9, 2.0
#: Fewest usual changes to compare with.
_FEWEST = 10
#: Share of the pauses with a larger change from which the values moved, and below which they did
#: not: between both, nothing is certain.
_MOVED, _STOOD = 0.75, 0.4


def moved_in_pauses(record: Channel, pauses: Sequence[float]) -> Optional[bool]:
    """Return True if values moved in pauses of the clock; None if that is not certain.

    A value that depends on the simulated clock changes over a pause as between any two messages.
    One that depends on the machine's clock changes by more, as each pause is much longer.

    :param record: the values, before and after the pauses
    :param pauses: times of the pauses by the simulated clock, in increasing order [s]
    """
    times, values = _distinct(record.finite())
    changes = [abs(after - one) for one, after in zip(values, values[1:])]
    over_pauses = {bisect.bisect_right(times, pause) - 1 for pause in pauses}
    jumps = [changes[one] for one in over_pauses if 0 <= one < len(changes)]
    usual = sorted(one for index, one in enumerate(changes) if index not in over_pauses)
    if len(usual) < _FEWEST or 2 * len(jumps) < len(pauses):
        return False  # sent too seldom, which is a flaw of its own
    largest = _FACTOR * usual[int(_USUAL * len(usual))]
    share = _share_above(jumps, largest)
    return True if share >= _MOVED else False if share < _STOOD else None


def _distinct(record: Channel) -> Tuple[List[float], List[float]]:
    """Return times and values without repeated values: a loop may send each several times."""
    pairs = zip(record.times, record.values)
    first = [next(equal) for _, equal in itertools.groupby(pairs, key=lambda pair: pair[1])]
    return [time for time, _ in first], [value for _, value in first]


def _share_above(values: List[float], limit: float) -> float:
    return sum(value > limit for value in values) / len(values)
