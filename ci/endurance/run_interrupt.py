"""Press Ctrl-C at a random moment of a node's life, again and again."""

import contextlib
import os
import random
import re
import signal
import statistics
import subprocess
import time
from typing import List, NamedTuple, Optional

import rosgraph

from ..benchmark.cost import stat_fields
from .checks import Check, at_most, none_of, reported
from .context import Soak
from .graph_state import NOTHING, address, of_node

TIMES = 100
#: Longest time until a node has ended [s].
ENDS_WITHIN = 2.0
#: First and last moment [s]: from the interpreter's first line of a node to a running node.
FIRST, LAST = 0.04, 2.5
#: A function of a node's package or of nodekit in a traceback; not the import of nodekit's first
#: module, before which nothing of it could handle Ctrl-C.
OUR_CODE = re.compile(r'/src/(nodekit|basic_comms)/src/\S+", line \d+, in (?!<module>)')
NODES = {
    "/talker": "talker.py",
    "/listener": "listener.py",
    "/signal_generator": "signal_generator.py",
    "/process": "process.py",
    "/fleet": "fleet",
}


class End(NamedTuple):
    """How a node ended, how long after the interrupt, and what is left of it."""

    what: str
    seconds: float
    #: None if it did not end
    status: Optional[int]
    output: str
    #: its registrations
    left_over: str
    children: List[int]

    @property
    def is_early(self) -> bool:
        """Whether there is a traceback of the interpreter, from before the node's first line."""
        return "Traceback" in self.output and OUR_CODE.search(self.output) is None


def run(soak: Soak) -> List[Check]:
    """Interrupt one node after the other."""
    chance, names = random.Random(soak.seed), list(NODES)
    with soak.session.node() as node:
        ends = [
            interrupt(soak, node.master, names[n % len(names)], chance.uniform(FIRST, LAST))
            for n in range(soak.times or TIMES)
        ]
    return report(ends)


def interrupt(soak: Soak, master: rosgraph.Master, name: str, moment: float) -> End:
    """Start a node, interrupt it at a moment of its life [s], and find what is left."""
    process = soak.start(NODES[name])
    time.sleep(moment)
    os.killpg(process.pid, signal.SIGINT)
    began = time.monotonic()
    status: Optional[int] = None
    with contextlib.suppress(subprocess.TimeoutExpired):
        status = process.wait(5.0 * ENDS_WITHIN)
    seconds = time.monotonic() - began
    children = [pid for pid, session in stat_fields(3).items() if session == process.pid]
    soak.session.stop(process)
    registered = of_node(master, name)
    left_over = "" if registered == NOTHING else str(registered)
    if address(master, name) is not None:
        left_over += " and its name"
    output = soak.session.log_of(process)
    return End(f"{name} after {moment:.3f} s", seconds, status, output, left_over, children)


def report(ends: List[End]) -> List[Check]:
    """Return the figures."""
    ours = [end for end in ends if not end.is_early]
    traces = [end for end in ours if "Traceback" in end.output]
    seconds = [end.seconds for end in ends]
    what = f"{len(ends)} times Ctrl-C: ended within"
    return [
        reported("median until the end", f"{statistics.median(seconds):.2f} s"),
        at_most(what, round(max(seconds), 2), ENDS_WITHIN, "s"),
        none_of(
            "exit status other than 0",
            [f"{end.what}: {end.status}" for end in ours if end.status != 0],
        ),
        none_of("tracebacks", [f"{end.what}: {end.output.split()[-1]}" for end in traces]),
        reported("the interpreter's own, before a node's first line", str(len(ends) - len(ours))),
        none_of("zombies and children", [end.what for end in ends if end.children]),
        none_of(
            "leftover registrations",
            [f"{end.what}: {end.left_over}" for end in ends if end.left_over],
        ),
    ]
