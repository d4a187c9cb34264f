"""Figures from recorded moments: latencies, periods, drift, medians over repeats."""

import bisect
import math
import random
import statistics
from typing import Callable, List, NamedTuple, Optional, Sequence

#: How many samples of the turns the interval of a median is made from.
RESAMPLES = 1000
#: How sure the interval is, given enough turns: the share of these samples whose median lies in it.
CONFIDENCE = 0.95


class Sample(NamedTuple):
    """A value and when it was sent or received."""

    #: on the machine's monotonic clock, s
    moment: float
    value: float


class Interval(NamedTuple):
    """Where a median lies, given how few turns there were."""

    low: float
    high: float


class Matched(NamedTuple):
    """What became of the samples that were sent."""

    #: moments of sending of the samples that arrived, s
    sent: List[float]
    #: how long each of them took, s
    latencies: List[float]
    #: how many of those after the first one to arrive did not
    lost: int


def percentile(values: Sequence[float], share: float) -> float:
    """Return the smallest value that a share of all values does not exceed (nearest rank).

    :param values: at least one
    :param share: between 0 and 1
    """
    if not values:
        raise ValueError("no values")
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


def match_in_order(
    sent: Sequence[float], received: Sequence[float], until: float = math.inf
) -> Matched:
    """Match each sample with its answer, where each one is answered at most once and in order.

    An answer belongs to the latest sample that leaves an earlier one to every later answer. So
    answers may be missing, at the start as a receiver joins late, or on the way. What this takes
    for granted is that the way is clear now and then: that some answers come within a period.

    :param sent: when the samples were sent, s, rising
    :param received: when the answers were received, s, rising
    :param until: when the nodes were asked to end, s; what is sent later may be lost
    """
    due = bisect.bisect_right(sent, until)
    numbers: List[int] = []
    bound = len(sent)
    for answer in reversed(received):
        bound = min(bound, bisect.bisect_left(sent, answer)) - 1
        numbers.append(bound)
    numbers.reverse()
    if not numbers:
        return Matched([], [], due)
    if numbers[0] < 0:
        raise ValueError("more answers than samples")
    return Matched(
        [sent[number] for number in numbers],
        [answer - sent[number] for number, answer in zip(numbers, received)],
        len(set(range(numbers[0], due)) - set(numbers)),
    )


def match_first_shown(sent: Sequence[Sample], received: Sequence[Sample]) -> Matched:
    """Match each sample with the first answer that shows it or a later one.

    For a receiver that answers at moments of its own with what it has got last. The values must
    rise from sample to sample, and an answer must show the value of its sample.

    :param sent: the samples
    :param received: the answers; they may lag behind float32's rounding
    """
    gaps = [later.value - sample.value for sample, later in zip(sent, sent[1:])]
    if any(gap <= 0.0 for gap in gaps):
        raise ValueError("the values do not rise")
    tolerance = 0.25 * min(gaps, default=0.0)
    moments: List[float] = []
    latencies: List[float] = []
    answers = iter(received)
    answer: Optional[Sample] = next(answers, None)
    for sample in sent:
        while answer is not None and (
            answer.moment < sample.moment or answer.value < sample.value - tolerance
        ):
            answer = next(answers, None)
        if answer is None:
            break
        moments.append(sample.moment)
        latencies.append(answer.moment - sample.moment)
    return Matched(moments, latencies, len(sent) - len(moments))


def periods(moments: Sequence[float]) -> List[float]:
    """Return the times from each moment to the next one, s."""
    return [later - moment for moment, later in zip(moments, moments[1:])]


def drift(calls: Sequence[Sample]) -> float:
    """Return how far a periodic task has moved against the clock, s; late is positive.

    How late each call comes scatters; so medians over the first and the last tenth are compared.

    :param calls: when the task was called, and as value the time that had passed by its own
        count, s; at least ten
    """
    if len(calls) < 10:
        raise ValueError("too few calls")
    tenth = len(calls) // 10
    late = [call.moment - call.value for call in calls]
    return statistics.median(late[-tenth:]) - statistics.median(late[:tenth])


def interval(values: Sequence[float]) -> Interval:
    """Return between which values the median of a figure lies, by the bootstrap's percentiles.

    Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 13: turns are drawn from
    the turns, with replacement and as many, and the medians of such draws scatter as the median
    itself does. The same values always give the same interval.

    :param values: the figure of each turn, at least one
    """
    draw = random.Random(0)
    medians = sorted(
        statistics.median(draw.choices(values, k=len(values))) for _ in range(RESAMPLES)
    )
    rest = (1.0 - CONFIDENCE) / 2.0
    return Interval(percentile(medians, rest), percentile(medians, 1.0 - rest))


def confidence(turns: int) -> float:
    """Return how sure an interval of some turns is.

    Each turn is above the median as often as below: all of them are on one side of it in one case
    of 2^(turns - 1). No interval of these turns is surer than from the least to the greatest.

    :param turns: how many there were, at least one
    """
    return min(CONFIDENCE, 1.0 - 0.5 ** (turns - 1))


def highest_passing(steps: Sequence[float], passes: Callable[[float], bool]) -> Optional[float]:
    """Find the highest step that passes, by bisection.

    :param steps: rising; where one passes, the lower ones are taken to pass as well
    :param passes: tries one
    :returns: None where none passes
    """
    low, high = 0, len(steps)
    while low < high:
        middle = (low + high) // 2
        if passes(steps[middle]):
            low = middle + 1
        else:
            high = middle
    return steps[low - 1] if low else None
