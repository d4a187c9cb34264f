"""Figures from recorded moments: latencies, and medians with their confidence intervals."""

import bisect
import math
from typing import List, NamedTuple, Sequence

import numpy as np

#: The confidence of an interval, given enough turns.
CONFIDENCE = 0.95
_RESAMPLES = 1000


class Matched(NamedTuple):
    """Times and latencies of the answered samples [s], and number of unanswered samples."""

    sent: List[float]
    latencies: List[float]
    lost: int


class Estimate(NamedTuple):
    """Median of a figure over turns, and its confidence interval."""

    median: float
    low: float
    high: float
    turns: int


def match_in_order(
    sent: Sequence[float], received: Sequence[float], until: float = math.inf
) -> Matched:
    """Match samples with answers: each is answered at most once, and in order.

    An answer belongs to the latest possible sample that still leaves an earlier sample for each
    other answer. So answers may be missing, at the start because a receiver joins late, or lost.
    This assumes that some answers arrive within a period.

    :param sent: when the samples were sent [s], rising
    :param received: when the answers were received [s], rising
    :param until: samples sent later may be lost [s]
    :raises ValueError: if there are more answers than samples
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


def estimate(values: Sequence[float]) -> Estimate:
    """Return the median of turns and its interval, by the bootstrap's percentiles.

    Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 13. The same values
    always give the same interval.

    :param values: the figure of each turn, at least one
    """
    draws = np.random.RandomState(0).choice(values, (_RESAMPLES, len(values)))
    rest = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(np.median(draws, axis=1), [rest, 100.0 - rest])
    return Estimate(float(np.median(values)), float(low), float(high), len(values))


def confidence(turns: int) -> float:
    """Return the confidence of an interval of some turns.

    All turns lie on one side of the median in one case of 2^(turns - 1), which bounds the
    confidence of any interval of them.
    """
    return min(CONFIDENCE, 1.0 - 0.5 ** (turns - 1))
