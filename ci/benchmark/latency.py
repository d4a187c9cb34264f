"""Latency from generator through process node to an observer, and its processor time."""

import contextlib
import functools
import time
from typing import Callable, ContextManager, Iterator

import numpy as np

from . import stacks
from .analysis import Matched, match_in_order
from .context import Bench, Figures
from .processes import paused, resumed

#: Length of a turn [s].
TURN_S = 1.0
#: Warm-up time at the start of a turn, for caches and overdue work [s].
SETTLE_S = 0.25


def at(rate: float) -> Callable[[Bench, str], ContextManager[Callable[[], Figures]]]:
    """Return the measurement at a rate [Hz]."""
    return functools.partial(_prepare, rate)


@contextlib.contextmanager
def _prepare(rate: float, bench: Bench, stack: str) -> Iterator[Callable[[], Figures]]:
    with stacks.up(bench.session, stack, rate) as pair, paused(pair.pids):
        yield lambda: _take_turn(pair)


def _take_turn(pair: stacks.Pair) -> Figures:
    began = time.monotonic()
    with resumed(pair.pids):
        run = stacks.watch(pair, SETTLE_S, TURN_S)
    return figures(answered(run, began), run)


def answered(run: stacks.Run, began: float = 0.0) -> Matched:
    """Match the samples of a turn with their answers.

    :param began: when the turn began [s]
    """
    # All samples: an earlier turn may have recorded samples without sending them.
    sent = [sample.moment for sample in run.sent]
    received = [sample.moment for sample in run.received if sample.moment >= began]
    return match_in_order(sent, received, run.until)


def figures(matched: Matched, run: stacks.Run) -> Figures:
    """Return the figures of the samples that were sent during the measured time.

    :raises ValueError: if nothing was answered
    """
    took = [
        1e6 * latency
        for moment, latency in zip(matched.sent, matched.latencies)
        if run.since <= moment <= run.until
    ]
    if not took:
        raise ValueError("no sample was answered")
    p50, p90, p99 = map(float, np.percentile(took, [50.0, 90.0, 99.0]))
    return {
        "p50_us": p50,
        "p90_us": p90,
        "p99_us": p99,
        "samples": len(took),
        "lost": matched.lost,
        "cpu_percent": run.cpu,
    }
