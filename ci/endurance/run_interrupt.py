"""Press Ctrl-C at a random moment of a node's life, again and again."""

import os
import pathlib
import random
import re
import signal
import subprocess
import time
from typing import List, NamedTuple, Optional

from ..benchmark.tcpros import Node
from .checks import Check, at_most, none_of, reported
from .graph_state import NOTHING, address, of_node
from .surroundings import Soak

TIMES = 100
#: longest time until a node has ended, s
ENDS_WITHIN = 2.0
#: the first moment, s; the interpreter itself takes that long to come to a node's first line
FIRST = 0.04
#: the last moment, s; the node has been running for a while then
LAST = 2.5
#: A function of a node's package or of nodekit in a traceback. That nodekit's first module is being
#: imported is no such thing: nothing of it runs yet that could take Ctrl-C.
OUR_CODE = re.compile(r'/src/(nodekit|basic_comms)/src/\S+", line \d+, in (?!<module>)')
NODES = {
    "/talker": "talker.py",
    "/listener": "listener.py",
    "/signal_generator": "signal_generator.py",
    "/process": "process.py",
    "/fleet": "fleet",
}


class End(NamedTuple):
    """How a node ended."""

    #: which one, and when it was interrupted
    what: str
    #: from the interrupt to the end, s
    seconds: float
    status: Optional[int]
    output: str
    #: what the master still knows of it
    left_over: str
    #: processes that it has left behind
    children: List[int]


def run(soak: Soak) -> List[Check]:
    """Interrupt one node after the other."""
    chance = random.Random(soak.seed)
    names = list(NODES)
    ends = []
    with soak.session.node() as node:
        for number in range(soak.times or TIMES):
            name = names[number % len(names)]
            ends.append(interrupt(soak, node, name, chance.uniform(FIRST, LAST)))
    return report(ends)


def interrupt(soak: Soak, node: Node, name: str, moment: float) -> End:
    """Start a node, interrupt it and look at what is left.

    :param moment: from its start on, s
    """
    process = soak.start(NODES[name])
    time.sleep(moment)
    os.killpg(process.pid, signal.SIGINT)
    began = time.monotonic()
    status: Optional[int] = None
    try:
        status = process.wait(5.0 * ENDS_WITHIN)
    except subprocess.TimeoutExpired:
        pass
    seconds = time.monotonic() - began
    children = in_session(process.pid)
    soak.session.stop(process)
    registered = of_node(node, name)
    left_over = "" if registered == NOTHING else str(registered)
    if address(node, name) is not None:
        left_over += " and its name"
    return End(
        f"{name} after {moment:.3f} s",
        seconds,
        status,
        soak.session.log_of(process),
        left_over,
        children,
    )


def in_session(session: int) -> List[int]:
    """Return the processes of a session, without those that have ended and been waited for."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session:
            found.append(int(stat.parent.name))
    return found


def is_before_our_code(output: str) -> bool:
    """Tell whether a traceback is the interpreter's own, from before a node's first line."""
    return OUR_CODE.search(output) is None


def report(ends: List[End]) -> List[Check]:
    """Return the figures."""
    traces = [end for end in ends if "Traceback" in end.output]
    early = [end for end in traces if is_before_our_code(end.output)]
    ours = [end for end in ends if end not in early]
    seconds = sorted(end.seconds for end in ends)
    what = f"{len(ends)} times Ctrl-C: ended within"
    return [
        reported("median until the end", f"{seconds[len(seconds) // 2]:.2f} s"),
        at_most(what, round(seconds[-1], 2), ENDS_WITHIN, "s"),
        none_of(
            "exit status other than 0",
            [f"{end.what}: {end.status}" for end in ours if end.status != 0],
        ),
        none_of(
            "tracebacks",
            [f"{end.what}: {last_line(end.output)}" for end in traces if end in ours],
        ),
        reported("the interpreter's own, before a node's first line", str(len(early))),
        none_of("zombies and children", [end.what for end in ends if end.children]),
        none_of(
            "leftover registrations",
            [f"{end.what}: {end.left_over}" for end in ends if end.left_over],
        ),
    ]


def last_line(text: str) -> str:
    """Return the last line that is not empty."""
    lines = text.strip().splitlines()
    return lines[-1] if lines else ""
