"""Live parameters: time from a set to its effect, and which value a burst ends on."""

import random
import struct
import time

import numpy as np

from .context import Bench, Figures
from .peer_programs import executable
from .recorder import Recorder, wait_until

NAME = "/signal_generator/amplitude"
SETS, BURST = 50, 200
AMPLITUDE = struct.Struct("<f")
#: The node reads all parameters once a second: a change by that shows within this time [s].
SETTLED = 2.5
LIMIT = 10.0


def measure(bench: Bench, _subject: str) -> Figures:
    """Set the amplitude of a generator at 1 kHz, one value after the other, then many at once."""
    chance, moments = random.Random(5), []
    with bench.session.node() as node:
        recorder = Recorder(node, "/signal", "basic_comms/signal_msg")
        with bench.session.up(executable("basic_comms", "signal_generator.py", "_rate:=1000")):
            recorder.wait()
            for number in range(20 if bench.is_quick else SETS):
                # The master notifies nodes every 0.1 s: set at any time in between.
                time.sleep(0.02 + 0.1 * chance.random())
                value = 3.0 + number
                moments.append((time.monotonic(), value))
                node.master.setParam(NAME, value)
                wait_until(lambda: _amplitude(recorder) == value, LIMIT, "effect of a set")
            for number in range(BURST):
                last = 1000.0 + number
                node.master.setParam(NAME, last)
            wait_until(lambda: _amplitude(recorder) == last, LIMIT, "end of the burst")
            time.sleep(SETTLED)
            is_good = _amplitude(recorder) == last == node.master.getParam(NAME)
        messages = iter(recorder.messages())
    delays = []
    for began, value in moments:
        for moment, message in messages:
            if moment > began and AMPLITUDE.unpack_from(message)[0] == value:
                delays.append(1e3 * (moment - began))
                break
    return {
        "median_ms": float(np.median(delays)),
        "longest_ms": max(delays),
        "wrong_after_burst": float(not is_good),
    }


def _amplitude(recorder: Recorder) -> float:
    message = recorder.latest()
    return float(AMPLITUDE.unpack_from(message)[0]) if message else 0.0
