"""Live parameters: time from a set to its effect, and final value of a burst."""

import random
import struct
import time
from typing import Dict

import numpy as np

from .context import Bench, Figures
from .peer_programs import executable
from .recorder import Recorder, wait_until

NAME = "/signal_generator/amplitude"
SETS, BURST = 50, 200
AMPLITUDE = struct.Struct("<f")
#: Longest time to an effect [s]: the node reads all parameters once a second.
SETTLED = 2.5
LIMIT = 10.0


def measure(bench: Bench, _subject: str) -> Figures:
    """Set the amplitude of a generator at 1 kHz, one value after the other, then in a burst."""
    chance, moments = random.Random(5), []
    generator = executable("basic_comms", "signal_generator.py", "_rate:=1000")
    set_param, get_param = bench.session.master.setParam, bench.session.master.getParam
    with bench.session.record("/signal", "basic_comms/signal_msg") as recorder:
        with bench.session.up(generator):
            recorder.wait()
            for number in range(20 if bench.is_quick else SETS):
                # The master notifies nodes every 0.1 s: set at any time in between.
                time.sleep(0.02 + 0.1 * chance.random())
                value = 3.0 + number
                moments.append((time.monotonic(), value))
                set_param(NAME, value)
                wait_until(lambda: _amplitude(recorder) == value, LIMIT, "effect of a set")
            for number in range(BURST):
                last = 1000.0 + number
                set_param(NAME, last)
            wait_until(lambda: _amplitude(recorder) == last, LIMIT, "end of the burst")
            time.sleep(SETTLED)
            is_good = _amplitude(recorder) == last == get_param(NAME)
    first: Dict[float, float] = {}
    for moment, message in recorder.messages:
        first.setdefault(AMPLITUDE.unpack_from(message)[0], moment)
    delays = [1e3 * (first[value] - began) for began, value in moments]
    return {
        "median_ms": float(np.median(delays)),
        "longest_ms": max(delays),
        "wrong_after_burst": float(not is_good),
    }


def _amplitude(recorder: Recorder) -> float:
    return float(AMPLITUDE.unpack_from(recorder.messages[-1][1])[0])
