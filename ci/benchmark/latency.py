"""From generator through process to an observer: how long a sample takes, and what it costs."""

import contextlib
import functools
import time
from typing import Callable, ContextManager, Iterator, List

from . import floor, stacks
from .analysis import Matched, match_first_shown, match_in_order, percentile
from .context import Bench, Figures
from .cost import cpu_share
from .pausing import going, standing

#: how long it is measured in a turn, s
TURN_S = 1.0
#: what a pair is given at the beginning of a turn, or of a run: connections, caches, what it does
#: once a second and is late with, s
SETTLE_S = 0.25
WARM_UP = 0.5

#: A slow sine rises throughout a short run, and passes an unscaled, unshifted process as it is:
#: each answer tells which sample it shows.
RISING = {
    "/signalGen_Frequency": 0.02,
    "/process_Scale": 1.0,
    "/process_Shift": 0.0,
}
#: The course's process polls at 10 Hz. A generator slightly off that meets all its phases.
COURSE_RATE = 9.7


def in_turns(rate: float) -> Callable[[Bench, str], ContextManager[Callable[[], Figures]]]:
    """Return what has a pair stand ready for turns at a rate in Hz."""
    return functools.partial(_stand_ready, rate)


@contextlib.contextmanager
def _stand_ready(rate: float, bench: Bench, stack: str) -> Iterator[Callable[[], Figures]]:
    """Have a stack that answers each sample stand ready, or the least that it could cost."""
    if stack == floor.FLOOR:
        with floor.up(rate) as pids, standing(pids):
            yield lambda: _floor_turn(pids)
    else:
        with stacks.up(bench.session, bench.peers, stack, rate) as pair, standing(pair.pids):
            yield lambda: _turn(pair)


def _floor_turn(pids: List[int]) -> Figures:
    with going(pids):
        time.sleep(SETTLE_S)
        return {"cpu_percent": cpu_share(pids, TURN_S)}


def _turn(pair: stacks.Pair) -> Figures:
    began = time.monotonic()
    with going(pair.pids):
        run = stacks.watch(pair, SETTLE_S, TURN_S)
    return figures(answered(run, began), run)


def at_10_hz(bench: Bench, stack: str) -> Figures:
    """Measure the workspace's nodes, or those of the course, at 10 Hz."""
    seconds = bench.seconds(3.0, 2.0)
    if stack != stacks.COURSE:
        return afresh(bench, stack, 10.0, seconds)
    with bench.session.node() as node:
        for name, value in RISING.items():
            node.master("setParam", name, value)
        with stacks.up(bench.session, bench.peers, stack, COURSE_RATE) as pair:
            run = stacks.watch(pair, WARM_UP, seconds)
        for name in RISING:
            node.master("deleteParam", name)
    matched = match_first_shown(run.sent, run.received)
    return figures(matched._replace(lost=0), run)  # it does not answer each one


def afresh(bench: Bench, stack: str, rate: float, seconds: float) -> Figures:
    """Start a stack that answers each sample, and measure it once."""
    with stacks.up(bench.session, bench.peers, stack, rate) as pair:
        run = stacks.watch(pair, WARM_UP, seconds)
    return figures(answered(run), run)


def answered(run: stacks.Run, began: float = 0.0) -> Matched:
    """Match the samples of a turn with their answers.

    :param began: when the turn began, s
    """
    # All that were sent: of an earlier turn, some may have been noted and not sent before it ended.
    sent = [sample.moment for sample in run.sent]
    received = [sample.moment for sample in run.received if sample.moment >= began]
    return match_in_order(sent, received, run.until)


def figures(matched: Matched, run: stacks.Run) -> Figures:
    """Return the figures of what was sent while a run was watched."""
    latencies = [
        latency
        for moment, latency in zip(matched.sent, matched.latencies)
        if run.since <= moment <= run.until
    ]
    return {
        "p50_us": 1e6 * percentile(latencies, 0.50),
        "p90_us": 1e6 * percentile(latencies, 0.90),
        "p99_us": 1e6 * percentile(latencies, 0.99),
        "samples": len(latencies),
        "lost": matched.lost,
        "cpu_percent": run.cpu,
    }
