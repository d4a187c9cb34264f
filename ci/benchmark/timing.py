"""How evenly the generator publishes at 1 kHz, beside the best loop that C++ offers."""

import time

import record
import stacks
from analysis import drift, percentile, periods
from context import Bench, Figures
from observers import Counter

RATE = 1000.0
#: what both are given to settle, s
WARM_UP = 0.5
LOOP = "clock_nanosleep"


def at_1_khz(bench: Bench, stack: str) -> Figures:
    """Measure the generator alone, an observer listening, or the loop in C++ alone."""
    file = bench.session.directory / ("timing-%s-%d" % (stack, time.monotonic_ns()))
    if stack == LOOP:
        seconds = WARM_UP + bench.seconds(5.0, 2.0)
        command = [str(bench.peers.roscpp / "periodic_loop"), str(file), "%g" % RATE]
        bench.session.start(command + ["%g" % seconds]).wait()
    else:
        seconds = WARM_UP + bench.seconds(20.0, 2.0)
        with bench.session.node() as node:
            counter = Counter(node)
            counter.watch("/signal", "basic_comms/signal_msg")
            generator = stacks.generator_command(bench.peers, stack, file, RATE)
            with bench.session.running(generator):
                while not counter.first:
                    time.sleep(0.01)
                time.sleep(seconds)
    calls = record.read(file)
    calls = [call for call in calls if call.moment >= calls[0].moment + WARM_UP]
    lengths = periods([call.moment for call in calls])
    return {
        "drift_ms": 1e3 * drift(calls),
        "period_p99_us": 1e6 * percentile(lengths, 0.99),
        "deviation_p99_us": 1e6 * percentile([abs(s - 1.0 / RATE) for s in lengths], 0.99),
    }
