"""Live parameters: how soon a set takes effect, what a burst ends on, what they cost, the exit."""

import random
import struct
import time

from . import stacks
from .analysis import percentile
from .context import Bench, Figures
from .cost import cpu_share
from .observers import Recorder, wait_until

SETS, BURST = 50, 200
AMPLITUDE = struct.Struct("<f")
#: The reconcile read comes once a second: what it changed would show within this time, s.
SETTLED = 2.5
LIMIT = 10.0


def effect(bench: Bench, _stack: str) -> Figures:
    """Set the amplitude of a generator at 1 kHz, one value after the other, then many at once."""
    session, chance = bench.session, random.Random(5)
    sets = 20 if bench.quick else SETS
    with session.node() as node:
        recorder = Recorder(node, "/signal", "basic_comms/signal_msg")
        with session.running(stacks.ours("signal_generator.py", "_rate:=1000")):
            recorder.wait()
            moments = []
            for number in range(sets):
                # The master looks every 0.1 s for what to tell: come at any time in between.
                time.sleep(0.02 + 0.1 * chance.random())
                value = 3.0 + number
                moments.append((time.monotonic(), value))
                node.master("setParam", "/signal_generator/amplitude", value)
                wait_until(lambda: _amplitude(recorder) == value, LIMIT, "effect of a set")
            for number in range(BURST):
                last = 1000.0 + number
                node.master("setParam", "/signal_generator/amplitude", last)
            wait_until(lambda: _amplitude(recorder) == last, LIMIT, "end of the burst")
            time.sleep(SETTLED)
            told = node.master("getParam", "/signal_generator/amplitude")
            good = _amplitude(recorder) == last == told
        messages = recorder.messages()
    delays = []
    shown = iter(messages)
    for asked, value in moments:
        for moment, message in shown:
            if moment > asked and AMPLITUDE.unpack_from(message)[0] == value:
                delays.append(1e3 * (moment - asked))
                break
    return {
        "median_ms": percentile(delays, 0.5),
        "longest_ms": max(delays),
        "burst_ends_on_last": float(good),
    }


def _amplitude(recorder: Recorder) -> float:
    message = recorder.latest()
    return AMPLITUDE.unpack_from(message)[0] if message else 0.0


def rest(bench: Bench, node: str) -> Figures:
    """Watch a node that nobody asks anything."""
    with bench.session.running(stacks.ours(node + ".py")) as pids:
        bench.session.wait_for("/" + node)
        return {"cpu_percent": cpu_share(pids, bench.seconds(8.0, 3.0))}


def leave(bench: Bench, node: str) -> Figures:
    """Interrupt a node that is between two samples, at 0.1 Hz where it has a rate."""
    slow = ["_rate:=0.1"] if node == "signal_generator" else []
    process = bench.session.start(stacks.ours(node + ".py", *slow))
    bench.session.wait_for("/" + node)
    return {"exit_s": bench.session.stop(process)}
