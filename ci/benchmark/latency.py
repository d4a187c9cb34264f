"""From generator through process to an observer: how long a sample takes, and what it costs."""

from typing import List

import floor
import stacks
from analysis import after_warm_up, match_first_shown, match_in_order, percentile
from context import Bench, Figures

#: what a run is given to settle: connections, caches, branch predictors, s
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


def at_1_khz(bench: Bench, stack: str) -> Figures:
    """Measure a stack that answers each sample, at 1 kHz, or the least that it could cost."""
    seconds = bench.seconds(2.5, 1.0)
    if stack == floor.FLOOR:
        return floor.measure(1000.0, seconds, WARM_UP)
    return _answering(bench, stack, 1000.0, seconds)


def at_100_hz(bench: Bench, stack: str) -> Figures:
    """Measure a stack that answers each sample, at 100 Hz."""
    return _answering(bench, stack, 100.0, bench.seconds(1.5, 1.0))


def at_10_hz(bench: Bench, stack: str) -> Figures:
    """Measure the workspace's nodes, or those of the course, at 10 Hz."""
    seconds = bench.seconds(3.0, 2.0)
    if stack != stacks.COURSE:
        return _answering(bench, stack, 10.0, seconds)
    run = stacks.run(
        bench.session, bench.peers, stack, COURSE_RATE, seconds, WARM_UP, course_parameters=RISING
    )
    matched = match_first_shown(run.sent, run.received)
    return _figures(after_warm_up(matched, WARM_UP), run.cpu, 0)


def _answering(bench: Bench, stack: str, rate: float, seconds: float) -> Figures:
    run = stacks.run(bench.session, bench.peers, stack, rate, seconds, WARM_UP)
    sent = [sample.moment for sample in run.sent]
    received = [sample.moment for sample in run.received]
    matched = match_in_order(sent, received, run.until)
    return _figures(after_warm_up(matched, WARM_UP), run.cpu, matched.lost)


def _figures(latencies: List[float], cpu: float, lost: int) -> Figures:
    return {
        "p50_us": 1e6 * percentile(latencies, 0.50),
        "p90_us": 1e6 * percentile(latencies, 0.90),
        "p99_us": 1e6 * percentile(latencies, 0.99),
        "samples": len(latencies),
        "lost": lost,
        "cpu_percent": cpu,
    }
