"""How evenly the generator publishes at 1 kHz, beside the best loop that C++ offers."""

import time
from typing import List

from . import record, stacks
from .analysis import Sample, drift, percentile, periods
from .context import Bench, Figures
from .observers import Counter, wait_until

RATE = 1000.0
#: what both are given to settle, s
WARM_UP = 0.5
#: longest wait for the first sample, and for an end that is due, s
PATIENCE_S = 30.0
LOOP = "clock_nanosleep"


def over_time(bench: Bench, stack: str) -> Figures:
    """Measure how far the generator drifts in 20 s."""
    return {"drift_ms": 1e3 * drift(_generator(bench, bench.seconds(20.0, 2.0)))}


def from_call_to_call(bench: Bench, stack: str) -> Figures:
    """Measure the periods of the generator, or of the loop in C++."""
    seconds = bench.seconds(4.0, 2.0)
    calls = _loop(bench, seconds) if stack == LOOP else _generator(bench, seconds)
    lengths = periods([call.moment for call in calls])
    return {
        "period_p99_us": 1e6 * percentile(lengths, 0.99),
        "deviation_p99_us": 1e6 * percentile([abs(s - 1.0 / RATE) for s in lengths], 0.99),
    }


def _generator(bench: Bench, seconds: float) -> List[Sample]:
    """Run the generator alone, with one observer that listens."""
    file = bench.session.directory / f"timing-{time.monotonic_ns()}"
    with bench.session.node() as node:
        counter = Counter(node)
        counter.watch("/signal", "basic_comms/signal_msg")
        generator = stacks.generator_command(bench.peers, stacks.OURS, file, RATE)
        with bench.session.running(generator):
            wait_until(lambda: bool(counter.first), PATIENCE_S, "sample")
            time.sleep(WARM_UP + seconds)
    return _settled(record.read(file))


def _loop(bench: Bench, seconds: float) -> List[Sample]:
    """Run the loop in C++ alone."""
    file = bench.session.directory / f"timing-{time.monotonic_ns()}"
    command = [str(bench.peers.roscpp / "periodic_loop"), str(file)]
    process = bench.session.start(command + [f"{RATE:g}", f"{WARM_UP + seconds:g}"])
    try:
        process.wait(WARM_UP + seconds + PATIENCE_S)
    finally:
        bench.session.stop(process)
    return _settled(record.read(file))


def _settled(calls: List[Sample]) -> List[Sample]:
    return [call for call in calls if call.moment >= calls[0].moment + WARM_UP]
