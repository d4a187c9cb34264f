"""Time from roslaunch to the first answer, and the memory of a node."""

import contextlib
import time
from typing import Callable, Iterator

from . import stacks
from .context import Bench, Figures
from .cost import usage
from .peer_programs import SCRIPTS, executable, peer

LAUNCH = {
    stacks.OURS: ["basic_comms", "cw1.launch"],
    stacks.COURSE: [str(SCRIPTS / "course" / "course.launch")],
}
NODES = {
    stacks.OURS: {
        "/signal_generator": executable("basic_comms", "signal_generator.py"),
        "/process": executable("basic_comms", "process.py"),
    },
    "bare_node": {"/bare_node": peer("bare_node.py")},
}


@contextlib.contextmanager
def prepare_launch(bench: Bench, stack: str) -> Iterator[Callable[[], Figures]]:
    """Measure the launch of two nodes, with a running master and observer, and cached files."""

    def take_turn() -> Figures:
        with bench.session.record("/proc_signal", "std_msgs/Float32") as recorder:
            began = time.monotonic()
            with bench.session.up(["roslaunch", *LAUNCH[stack]]):
                return {"first_answer_s": recorder.wait() - began}

    take_turn()
    yield take_turn


def measure_memory(bench: Bench, subject: str) -> Figures:
    """Measure the largest of a subject's nodes, each alone with its default parameters."""
    sizes = []
    for name, command in NODES[subject].items():
        with bench.session.up(command) as (pid,):
            bench.session.wait_for(name)
            sizes.append(usage(pid).memory / 1024.0)
    return {"resident_mb": max(sizes)}
